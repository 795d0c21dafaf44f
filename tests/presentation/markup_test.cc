#include "presentation/markup.h"

#include <gtest/gtest.h>

namespace gyrobench::presentation {
namespace {

TEST(Markup, EscapesEveryCharacterThatMarkupIsMadeOf) {
  EXPECT_EQ(Markup::Text("<a b=\"c\" d='e'>&</a>").html(),
            "&lt;a b=&quot;c&quot; d=&#39;e&#39;&gt;&amp;&lt;/a&gt;");
}

TEST(Markup, KeepsTextOfAllScripts) {
  const std::string text = "±0.5 °/√s – Ω 陀螺 🛰";
  EXPECT_EQ(Markup::Text(text).html(), text);
}

TEST(CleanText, MakesOneLineOfValidUtf8) {
  EXPECT_EQ(CleanText("a\nb\tc\r"), "a b c ");
  EXPECT_EQ(CleanText(std::string("a\0b", 3)), "a\uFFFDb");
  EXPECT_EQ(CleanText("\xff"), "\uFFFD");
  EXPECT_EQ(CleanText("cut short \xE2\x82"), "cut short \uFFFD");
}

TEST(CleanText, ShowsCharactersThatWouldTurnTheLineAround) {
  EXPECT_EQ(CleanText("gnp\u202Ehtml"), "gnp\uFFFDhtml");
}

}  // namespace
}  // namespace gyrobench::presentation
