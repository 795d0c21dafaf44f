#include "cli/control_client.h"

#include <fmt/format.h>
#include <grp.h>
#include <sys/stat.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "base/json_text.h"
#include "cli/exit_status.h"

namespace gyrobench::cli {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using boost::system::error_code;

// "root:gyrobench 0660", for a person who may not open the socket.
std::string Ownership(const std::filesystem::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) != 0) return "its owner";
  const group* owner = getgrgid(status.st_gid);
  const std::string name = owner != nullptr ? owner->gr_name : std::to_string(status.st_gid);
  return fmt::format("group '{}', mode {:04o}", name, status.st_mode & 07777U);
}

struct Exchange {
  error_code error;
  bool connected = false;
  bool finished = false;
  http::response<http::string_body> response;
};

// One request and its answer, all steps within `timeout`.
Exchange Run(const std::string& socket_path, const http::request<http::string_body>& request,
             std::chrono::milliseconds timeout) {
  Exchange exchange;
  asio::io_context context;
  asio::local::stream_protocol::socket socket(context);
  boost::beast::flat_buffer buffer;
  const auto end = [&](error_code error) {
    exchange.error = error;
    exchange.finished = true;
  };
  const auto read = [&](error_code error, std::size_t) {
    if (error) return end(error);
    http::async_read(socket, buffer, exchange.response,
                     [&](error_code failed, std::size_t) { end(failed); });
  };
  socket.async_connect({socket_path}, [&](error_code error) {
    if (error) return end(error);
    exchange.connected = true;
    http::async_write(socket, request, read);
  });
  context.run_for(timeout);
  // Handlers refer to locals: they end before these do.
  if (!exchange.finished) {
    error_code ignored;
    socket.close(ignored);
    context.restart();
    context.run();
    exchange.finished = false;
  }
  return exchange;
}

nlohmann::json ParseAnswer(const std::filesystem::path& socket, const std::string& target,
                           const http::response<http::string_body>& response) {
  const nlohmann::json answer = nlohmann::json::parse(response.body(), nullptr, false);
  const int status = static_cast<int>(response.result_int());
  if (status < 400) {
    if (answer.is_object()) return answer;
    throw UnreachableError(fmt::format(
        "{}: {} answered no JSON object; is it gyrobenchd that listens there, of the same version?",
        socket.string(), target));
  }
  const nlohmann::json none = nlohmann::json::object();
  const nlohmann::json& error =
      answer.is_object() && answer.contains("error") && answer["error"].is_object()
          ? answer["error"]
          : none;
  std::string message = error.value("message", fmt::format("{} answered HTTP {}", target, status));
  const std::string where = error.value("where", "");
  // The message of a script's error begins with its place already.
  if (!where.empty() && message.find(where) == std::string::npos) message = where + ": " + message;
  throw RefusedError(message, status, error.value("code", ""));
}

}  // namespace

ControlClient::ControlClient(std::filesystem::path socket, std::string daemon_command,
                             double timeout_s)
    : socket_(std::move(socket)),
      daemon_command_(std::move(daemon_command)),
      timeout_s_(timeout_s) {}

nlohmann::json ControlClient::Get(const std::string& target) const {
  return Request(false, target, "");
}

nlohmann::json ControlClient::Post(const std::string& target, const nlohmann::json& body) const {
  return Request(true, target, JsonText(body));
}

void ControlClient::ThrowUnreachable(int error_number) const {
  if (error_number == ENOENT || error_number == ECONNREFUSED) {
    throw UnreachableError(
        fmt::format("the daemon is not running: {} at the control socket {}; start it with: {}",
                    error_number == ENOENT ? "nothing is" : "nobody answers", socket_.string(),
                    daemon_command_));
  }
  if (error_number == EACCES || error_number == EPERM) {
    throw UnreachableError(fmt::format(
        "no permission for the control socket {} ({}): ask for membership of that group, or run as "
        "its owner",
        socket_.string(), Ownership(socket_)));
  }
  throw UnreachableError(
      fmt::format("control socket {}: {}", socket_.string(), std::strerror(error_number)));
}

nlohmann::json ControlClient::Request(bool post, const std::string& target,
                                      const std::string& body) const {
  // sockaddr_un's limit; asio's own message would not name the path.
  if (socket_.native().size() > 107) {
    throw UnreachableError(fmt::format(
        "control socket {}: a Unix socket's path has at most 107 characters, this one {}",
        socket_.string(), socket_.native().size()));
  }
  http::request<http::string_body> request{post ? http::verb::post : http::verb::get, target, 11};
  request.set(http::field::host, "localhost");
  request.set(http::field::connection, "close");
  if (post) request.set(http::field::content_type, "application/json");
  request.body() = body;
  request.prepare_payload();

  const auto timeout = std::chrono::milliseconds(static_cast<std::int64_t>(timeout_s_ * 1e3));
  const Exchange exchange = Run(socket_.string(), request, timeout);
  if (!exchange.finished) {
    throw UnreachableError(fmt::format(
        "the daemon at {} did not answer {} within {:g} s; it may be hung: look at its log",
        socket_.string(), target, timeout_s_));
  }
  if (exchange.error && !exchange.connected) ThrowUnreachable(exchange.error.value());
  if (exchange.error) {
    throw UnreachableError(
        fmt::format("the daemon at {} broke off while answering {} ({}); look at its log",
                    socket_.string(), target, exchange.error.message()));
  }
  return ParseAnswer(socket_, target, exchange.response);
}

namespace {

template <typename Number>
bool ReadsAs(const std::string& text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

nlohmann::json ParameterValue(const std::string& text) {
  std::int64_t integer = 0;
  double number = 0.0;
  if (ReadsAs(text, integer)) return integer;
  // JSON has no infinity: such a text is sent as it is, and refused with its name.
  if (ReadsAs(text, number) && std::isfinite(number)) return number;
  if (text == "true") return true;
  if (text == "false") return false;
  return text;
}

nlohmann::json RunRequest(const Options& options) {
  nlohmann::json parameters = nlohmann::json::object();
  for (const auto& [key, value] : options.parameters) {
    if (parameters.contains(key)) {
      throw UsageError(fmt::format("parameter '{}' is given twice: give it once", key));
    }
    parameters[key] = ParameterValue(value);
  }
  return {{"procedure", options.name}, {"parameters", parameters}};
}

}  // namespace gyrobench::cli
