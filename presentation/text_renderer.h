// A document on a terminal.
#pragma once

#include <string>

#include "presentation/document.h"
#include "presentation/text_layout.h"

namespace gyrobench::presentation {

// Sections of the outermost level stand apart by an empty line; what is in a section stands two
// columns further right than its title. Each line ends in a newline.
std::string RenderText(const Document& document, const Terminal& terminal);

}  // namespace gyrobench::presentation
