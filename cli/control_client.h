// The daemon's control socket, as a client: docs/control-api.md.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.h"
#include "cli/options.h"

namespace gyrobench::cli {

// The daemon refused a request: what() is its message with the place.
class RefusedError : public Error {
 public:
  RefusedError(const std::string& message, int status, std::string code)
      : Error(message), status_(status), code_(std::move(code)) {}
  int status() const { return status_; }  // of HTTP: 400, 404, 409, 422, 500
  const std::string& code() const { return code_; }

 private:
  int status_;
  std::string code_;
};

// The daemon cannot be reached, or broke off, or answered what is no answer.
class UnreachableError : public Error {
 public:
  using Error::Error;
};

// One request a connection. A request that is not answered within `timeout_s` is an
// UnreachableError.
class ControlClient {
 public:
  // `daemon_command`: what to type to start the daemon, for messages.
  ControlClient(std::filesystem::path socket, std::string daemon_command, double timeout_s = 60.0);
  // `target`: "/v1/status". Both return the answer's body.
  nlohmann::json Get(const std::string& target) const;
  nlohmann::json Post(const std::string& target, const nlohmann::json& body) const;

 private:
  nlohmann::json Request(bool post, const std::string& target, const std::string& body) const;
  [[noreturn]] void ThrowUnreachable(int error_number) const;

  std::filesystem::path socket_;
  std::string daemon_command_;
  double timeout_s_;
};

// What reads as a whole as a number or as true or false is one; all else is text.
nlohmann::json ParameterValue(const std::string& text);

// {"procedure", "parameters"}. UsageError when a parameter is given twice.
nlohmann::json RunRequest(const Options& options);

}  // namespace gyrobench::cli
