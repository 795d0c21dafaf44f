#include "daemon/control_api.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/json_text.h"
#include "base/version.h"
#include "daemon/run_record.h"
#include "procedures/engine/engine.h"

namespace gyrobench::daemon {
namespace {

using nlohmann::json;

HttpReply Fail(unsigned status, const char* code, const std::string& message,
               const std::string& where = "") {
  return {status,
          JsonText(json{{"error", {{"code", code}, {"message", message}, {"where", where}}}})};
}

// With the fields that are known of it.
HttpReply Fail(unsigned status, const char* code, const Error& error) {
  const Fault fields = FaultOf("", error);
  return {status, JsonText(json{{"error",
                                 {{"code", code},
                                  {"message", fields.message},
                                  {"where", ""},
                                  {"device", daemon::ToJson(fields.failure)},
                                  {"script", daemon::ToJson(fields.place)}}}})};
}

json ParseBody(const std::string& body) {
  if (body.empty()) return json::object();
  json parsed = json::parse(body);
  if (!parsed.is_object()) throw Error("the body must be a JSON object");
  return parsed;
}

std::string Text(const json& body, const char* key) {
  const auto found = body.find(key);
  if (found == body.end() || !found->is_string()) {
    throw Error(std::string("the body needs \"") + key + "\", a text");
  }
  return *found;
}

procedures::Parameters ReadParameters(const json& body) {
  const auto found = body.find("parameters");
  if (found == body.end() || found->is_null()) return {};
  if (!found->is_object()) throw Error("\"parameters\" must be an object of name to value");
  return ParametersFrom(*found);
}

json ToJson(const procedures::Parameter& parameter) {
  json object{{"name", parameter.name},
              {"type", procedures::Name(parameter.type)},
              {"unit", parameter.unit},
              {"choices", parameter.choices},
              {"help", parameter.help}};
  std::visit([&](const auto& value) { object["default"] = value; }, parameter.default_value);
  object["min"] = Number(parameter.min);
  object["max"] = Number(parameter.max);
  return object;
}

json ToJson(const RunView& run, State state) {
  const bool on = run.outcome == Outcome::kNone;
  json failures = json::array();
  for (const Fault& failure : run.failures) failures.push_back(daemon::ToJson(failure));
  return {{"run_id", run.run_id},
          {"procedure", run.procedure},
          {"parameters", daemon::ToJson(run.parameters)},
          {"record", run.record},
          {"state", on ? Name(state) : "ended"},
          {"outcome", Name(run.outcome)},
          {"segment", run.progress.segment},
          {"segments_done", run.progress.segments_done},
          {"progress", on ? run.progress.fraction : 1.0},
          {"elapsed_s", run.elapsed_s},
          {"remaining_s", Number(run.progress.remaining_s)},
          {"message", run.progress.message},
          {"failures", std::move(failures)}};
}

json Devices(const Acquisition& acquisition) {
  json list = json::array();
  for (const DeviceStatus& device : acquisition.Devices()) {
    list.push_back({{"name", device.name},
                    {"kind", device.kind},
                    {"bus", device.bus},
                    {"unit", device.unit},
                    {"ok", device.ok},
                    {"message", device.message},
                    {"failure", daemon::ToJson(device.failure)}});
  }
  return list;
}

using Context = ControlApi::Context;

json ActingInputs(const drivers::AxisState& drive) {
  json acting = json::array();
  if (drive.emergency_stop) acting.push_back("emergency stop");
  if (drive.limit_plus) acting.push_back("limit +");
  if (drive.limit_minus) acting.push_back("limit -");
  return acting;
}

// What is not known yet is null.
json Axes(const Context& c) {
  json list = json::array();
  for (const config::AxisConfig& axis : c.stand.axes) {
    const AxisView view = c.acquisition.Axis(axis.name);
    json object{{"name", axis.name}, {"reference_deg", nullptr}, {"commanded_deg", nullptr},
                {"moving", nullptr}, {"enabled", nullptr},       {"inputs", nullptr}};
    if (view.reference.utime != 0) object["reference_deg"] = Number(view.reference.angle_deg);
    if (view.drive.utime != 0) {
      object["commanded_deg"] = Number(view.drive.commanded_deg);
      object["moving"] = view.drive.moving;
      object["enabled"] = view.drive.enabled;
      object["inputs"] = ActingInputs(view.drive);
    }
    list.push_back(std::move(object));
  }
  return list;
}

json NoticeList(const Context& c) {
  json list = json::array();
  for (const Notice& notice : c.notices.List()) {
    list.push_back({{"utime", notice.utime}, {"text", notice.text}});
  }
  return list;
}

json Status(Context& c) {
  const SensorView sensor = c.acquisition.Sensor();
  json status{{"state", Name(c.control.state())},
              {"stand", c.stand.name},
              {"virtual_stand", c.stand.virtual_stand.has_value()},
              {"time_stands_still", c.time.stands_still()},
              {"run", nullptr},
              {"question", nullptr},
              {"fault", nullptr},
              {"devices", Devices(c.acquisition)},
              {"axes", Axes(c)},
              {"notices", NoticeList(c)},
              {"temperature_degC", Number(sensor.temperature_degC)},
              {"tick_ratio", Number(sensor.tick_ratio)},
              {"utime", c.clock.Now()},
              {"version", kVersion},
              {"instance", recording::Name(c.publisher.sender())}};
  if (const Outputs* outputs = c.acquisition.outputs()) {
    for (const auto& [output, on] : outputs->States()) {
      status["outputs"][output] = on ? json(*on) : json();
    }
  }
  if (const auto run = c.engine.View()) status["run"] = ToJson(*run, c.control.state());
  if (const auto question = c.control.question()) {
    status["question"] = {
        {"id", question->id}, {"text", question->text}, {"choices", question->choices}};
  }
  if (const auto fault = c.control.fault()) status["fault"] = daemon::ToJson(*fault);
  const std::string lcm = c.publisher.health();
  status["lcm"] = {{"url", c.stand.lcm.url},
                   {"channel_prefix", c.stand.lcm.channel_prefix},
                   {"ok", lcm.empty()},
                   {"message", lcm}};
  return status;
}

json Procedures(Context& c) {
  json list = json::array();
  for (const procedures::ProcedureInfo& info : c.engine.library().List()) {
    json parameters = json::array();
    for (const procedures::Parameter& parameter : info.parameters) {
      parameters.push_back(ToJson(parameter));
    }
    list.push_back({{"name", info.name},
                    {"summary", info.summary},
                    {"description", info.description},
                    {"file", info.file.string()},
                    {"parameters", parameters},
                    {"measures", info.measures},
                    {"resumable", info.resumable},
                    {"problem", info.problem}});
  }
  return {{"procedures", list}};
}

json ToJson(const procedures::PlannedQuestion& planned) {
  json object{{"at_s", planned.at_s},
              {"id", planned.question.id},
              {"text", planned.question.text},
              {"choices", planned.question.choices},
              {"configured_answer", nullptr}};
  if (planned.configured_answer) object["configured_answer"] = *planned.configured_answer;
  return object;
}

json Check(Context& c, const json& body) {
  const procedures::Plan plan = c.engine.Check(Text(body, "procedure"), ReadParameters(body));
  json moves = json::array();
  for (const procedures::PlannedMove& move : plan.moves) {
    moves.push_back({{"axis", move.axis},
                     {"from_deg", move.from_deg},
                     {"to_deg", move.to_deg},
                     {"angle_deg", move.to_deg - move.from_deg},
                     {"rate_deg_s", move.rate_deg_s}});
  }
  json questions = json::array();
  for (const procedures::PlannedQuestion& question : plan.questions) {
    questions.push_back(ToJson(question));
  }
  return {{"duration_s", plan.expected_duration_s},
          {"longest_duration_s", plan.duration_s},
          {"segments", plan.segments.size()},
          {"moves", moves},
          {"questions", questions},
          {"notes", plan.notes}};
}

json ToJson(const StartedRun& run) {
  return {{"run_id", run.run_id}, {"record", run.record}, {"duration_s", run.duration_s}};
}

json Start(Context& c, const json& body, std::optional<std::int64_t> stops) {
  return ToJson(c.engine.Start(Text(body, "procedure"), ReadParameters(body), stops));
}

json TakeUp(Context& c, const json& body, std::optional<std::int64_t> stops) {
  return ToJson(c.engine.Resume(Text(body, "run"), stops));
}

// Motion ends in every state: with a run by its abort, and without one all the same.
void Stop(Context& c) { c.engine.Stop("stopped by the operator (gyrobench stop)"); }

enum Lane : std::size_t { kStopping, kSteering, kStarting, kRehearsing };
static_assert(kRehearsing + 1 == ControlApi::kLanes && kStarting == ControlApi::kQuickLanes);

// What a request needs.
enum class Right {
  kConnect,  // to look, to rehearse, and to stop: whoever sees a danger may
  kMove
};

struct Route {
  unsigned status;
  std::function<json(Context&, const HttpRequest&)> act;
  Right right = Right::kConnect;
};

Route Query(json (*act)(Context&)) {
  return {200, [act](Context& c, const HttpRequest&) { return act(c); }};
}

Route Request(Right right, json (*act)(Context&, const json& body)) {
  return {200,
          [act](Context& c, const HttpRequest& request) { return act(c, ParseBody(request.body)); },
          right};
}

json Lines(Context& c) { return BusStatus(c.stand, c.acquisition.Lines()); }

json StateOf(const Context& c) { return {{"state", Name(c.control.state())}}; }

// Answers with the state. It needs no body: what ends a motion does so whatever stands there.
Route Action(Right right, void (*act)(Context&)) {
  return {200,
          [act](Context& c, const HttpRequest&) {
            act(c);
            return StateOf(c);
          },
          right};
}

json Answer(Context& c, const json& body) {
  c.control.Answer(Text(body, "answer"));
  return StateOf(c);
}

const std::map<std::pair<std::string, std::string>, Route>& Routes() {
  static const std::map<std::pair<std::string, std::string>, Route> routes = {
      {{"GET", "/v1/status"}, Query(Status)},
      {{"GET", "/v1/bus"}, Query(Lines)},
      {{"GET", "/v1/procedures"}, Query(Procedures)},
      {{"POST", "/v1/check"}, Request(Right::kConnect, Check)},
      {{"POST", "/v1/runs"},
       {201,
        [](Context& c, const HttpRequest& request) {
          return Start(c, ParseBody(request.body), request.stamp);
        },
        Right::kMove}},
      {{"POST", "/v1/runs/resume"},
       {201,
        [](Context& c, const HttpRequest& request) {
          return TakeUp(c, ParseBody(request.body), request.stamp);
        },
        Right::kMove}},
      {{"POST", "/v1/answer"}, Request(Right::kMove, Answer)},
      {{"POST", "/v1/pause"}, Action(Right::kMove, [](Context& c) { c.control.Pause(); })},
      {{"POST", "/v1/resume"}, Action(Right::kMove, [](Context& c) { c.control.Resume(); })},
      {{"POST", "/v1/abort"}, Action(Right::kMove, [](Context& c) { c.control.Abort(); })},
      {{"POST", "/v1/stop"}, Action(Right::kConnect, Stop)},
      {{"POST", "/v1/reset"}, Action(Right::kMove, [](Context& c) {
         c.engine.Reset();
         c.notices.Clear();
       })}};
  return routes;
}

HttpReply Act(const Route& route, Context& c, const HttpRequest& request) {
  if (route.right == Right::kMove && !c.access.MayMove(request.peer)) {
    return Fail(403, "not_permitted",
                fmt::format("{} may look at this stand, rehearse and stop it; to move it takes one "
                            "of: {} (control_movers in the stand file)",
                            NumberOf(*request.peer), c.access.movers()),
                request.path);
  }
  try {
    const json answer = route.act(c, request);
    return {route.status, JsonText(answer)};
  } catch (const json::exception& error) {
    return Fail(400, "bad_json", error.what(), request.path);
  } catch (const StateError& error) {
    return Fail(409, "wrong_state", error);
  } catch (const procedures::UnknownProcedure& error) {
    return Fail(404, "no_such_procedure", error);
  } catch (const procedures::ParameterError& error) {
    return Fail(422, "bad_parameter", error);
  } catch (const LimitError& error) {
    return Fail(422, "beyond_limit", error);
  } catch (const DeviceError& error) {
    return Fail(409, "device", error);
  } catch (const DataError& error) {
    return Fail(500, "record", error);
  } catch (const Error& error) {
    return Fail(422, "refused", error);
  } catch (const std::exception& error) {
    return Fail(500, "internal", error.what());
  }
}

}  // namespace

std::size_t ControlApi::LaneOf(const HttpRequest& request) {
  if (request.path == "/v1/stop") return kStopping;
  if (request.path == "/v1/runs" || request.path == "/v1/runs/resume") return kStarting;
  const bool rehearses = request.path == "/v1/check" || request.path == "/v1/procedures";
  return rehearses ? kRehearsing : kSteering;
}

std::int64_t ControlApi::Stamp() const { return context_.control.stops(); }

ControlApi::ControlApi(const Context& context) : context_(context) {}

HttpReply ControlApi::Handle(const HttpRequest& request) {
  const auto route = Routes().find({request.method, request.path});
  if (route == Routes().end()) {
    return Fail(404, "no_such_request",
                request.method + " " + request.path + " is not known; see docs/control-api.md",
                request.path);
  }
  HttpReply reply = Act(route->second, context_, request);
  if (request.peer && request.method == "POST") log_.Add(*request.peer, request.path, reply.status);
  return reply;
}

}  // namespace gyrobench::daemon
