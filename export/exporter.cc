#include "export/exporter.h"

#include <algorithm>

#include "export/formats.h"

namespace gyrobench::exporting {

std::span<const Format> Formats() { return kFormats; }

const Format* FindFormat(std::string_view name) {
  const auto* const found = std::ranges::find(kFormats, name, &Format::name);
  return found == kFormats.end() ? nullptr : found;
}

}  // namespace gyrobench::exporting
