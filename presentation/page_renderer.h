// A document on a page.
#pragma once

#include "presentation/charter.h"
#include "presentation/document.h"
#include "presentation/markup.h"

namespace gyrobench::presentation {

// Sections become <section> with <h2>, those in them <h3> and <h4>. Numbers and units are typeset,
// the columns of numbers aligned by their decimal points, charts drawn by `charter`.
Markup RenderPage(const Document& document, Charter& charter);

}  // namespace gyrobench::presentation
