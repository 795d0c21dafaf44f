#include "config/toml_edit.h"

#include <gmock/gmock.h>

#include "base/error.h"
#include "config/toml_reader.h"

namespace gyrobench::config {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kText = R"(# A stand.
name = "one"   # mine

[axis.inner]
gear_ratio = 40   # of the worm
  [axis.inner.encoder]
  unit = 13  # by its label

[site]
)";

TEST(TomlEdit, AValueChangesInItsPlaceAndAllElseStays) {
  EXPECT_EQ(Edited(kText, "stand.toml", {{"axis.inner.gear_ratio", "20", "was 40"}}), R"(# A stand.
name = "one"   # mine

[axis.inner]
# was 40
gear_ratio = 20   # of the worm
  [axis.inner.encoder]
  unit = 13  # by its label

[site]
)");
}

// What the text does not say is said by another file, or by a default.
TEST(TomlEdit, AKeyThatIsNotThereComesIntoItsTableOrOneAtTheEnd) {
  const std::string edited = Edited(kText, "stand.toml",
                                    {{"site.heading_deg", "5", "turned"},
                                     {"axis.outer.drive.sign", "-1", "reversed"},
                                     {"axis.outer.drive.unit", "3", "exchanged"},
                                     {"records", "\"here\"", "kept"}});
  EXPECT_THAT(edited, StartsWith("# kept\nrecords = \"here\"\n# A stand."));
  EXPECT_THAT(edited, HasSubstr("[site]\n# turned\nheading_deg = 5\n"));
  const TomlTable root = TomlTable::FromText(edited, "stand.toml");
  EXPECT_EQ(root.Table("axis").Table("outer").Table("drive").Integer("unit", {}), 3);
  EXPECT_EQ(root.Table("axis").Table("outer").Table("drive").Integer("sign", {}), -1);
}

// Each value after any number of edits is the last one that was given.
TEST(TomlEdit, EditsOfOneKeyFollowEachOther) {
  const std::string edited = Edited(kText, "stand.toml",
                                    {{"axis.inner.encoder.unit", "7", "first"},
                                     {"name", "\"a # b\"", "then"},
                                     {"axis.inner.encoder.unit", "300000", "last"}});
  const TomlTable root = TomlTable::FromText(edited, "stand.toml");
  EXPECT_EQ(root.String("name"), "a # b");
  EXPECT_EQ(root.Table("axis").Table("inner").Table("encoder").Integer("unit", {}), 300000);
  EXPECT_THAT(edited, HasSubstr("unit = 300000  # by its label"));
}

TEST(TomlEdit, ATableOfDottedKeysIsAddedToInItsOwnWay) {
  const std::string text =
      "[ axis.middle ]\ndrive.unit = 2\nencoder = {unit = 12, map = \"карта\", "
      "sign = -1}\n";
  const std::string edited =
      Edited(text, "stand.toml",
             {{"axis.middle.drive.sign", "-1", "a"}, {"axis.middle.encoder.sign", "1", "b"}});
  const TomlTable middle = TomlTable::FromText(edited, "stand.toml").Table("axis").Table("middle");
  EXPECT_EQ(middle.Table("drive").Integer("sign", {}), -1);
  EXPECT_EQ(middle.Table("drive").Integer("unit", {}), 2);
  EXPECT_EQ(middle.Table("encoder").Integer("sign", {}), 1);
  EXPECT_EQ(middle.Table("encoder").String("map"), "карта");
}

TEST(TomlEdit, WhatIsNoTomlIsRefusedWithItsLine) {
  EXPECT_THROW(Edited("name = = 1\n", "stand.toml", {{"name", "2", ""}}), ConfigError);
  EXPECT_THROW(Edited(kText, "stand.toml", {{"name", "\"open", ""}}), ConfigError);
  // An inline table cannot be added to by a head.
  EXPECT_THROW(Edited("site = {heading_deg = 1}\n", "stand.toml", {{"site.latitude_deg", "2", ""}}),
               ConfigError);
}

}  // namespace
}  // namespace gyrobench::config
