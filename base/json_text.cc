#include "base/json_text.h"

namespace gyrobench {
namespace {

template <typename Json>
std::string Text(const Json& value, int indent) {
  return value.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string JsonText(const nlohmann::json& value, int indent) { return Text(value, indent); }
std::string JsonText(const nlohmann::ordered_json& value, int indent) {
  return Text(value, indent);
}

}  // namespace gyrobench
