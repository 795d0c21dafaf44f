#include <cstdint>
#include <string_view>

#include "cli/live_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

// Each field under its own name. What stands for a constant has its name.
struct ToJson {
  Json& json;

  void operator()(const char* name, const ConstantOf& constant) const {
    json[name] = constant.name.empty() ? Json(constant.value) : Json(constant.name);
  }
  template <typename Value>
  void operator()(const char* name, const Value& value) const {
    json[name] = value;
  }
  void operator()(const char* name, std::int8_t value) const {
    json[name] =
        std::string_view(name) == "sensor_axis" ? Json(SensorAxisName(value)) : Json(value);
  }
};

Json Whole(const Undecoded& m) { return {{"undecoded", m.why}}; }

template <typename Message>
Json Whole(const Message& message) {
  Json json;
  Reflection<Message>::Fields(message, ToJson{json});
  return json;
}

}  // namespace

Json LiveJson(const LiveMessage& message) {
  Json json = std::visit([](const auto& m) { return Whole(m); }, message.body);
  json["channel"] = message.channel;
  json["lost"] = message.lost;
  json["sender"] = message.sender.empty() ? Json() : Json(message.sender);
  json["stranger"] = !message.stranger.empty();
  return json;
}

}  // namespace gyrobench::cli
