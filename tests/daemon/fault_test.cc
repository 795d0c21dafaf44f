// What is known of a fault, in the form in which records and clients have it.
#include "daemon/fault.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace gyrobench::daemon {
namespace {

using nlohmann::json;

// Every field has a value of its own, so that a swap shows.
TEST(Fault, HasAllFieldsOfTheErrorThatItIsOf) {
  DeviceError error("exception 03", {.device = "axis.inner drive",
                                     .action = "move",
                                     .code_kind = DeviceFailure::CodeKind::kModbusException,
                                     .code = 3,
                                     .address = 0x6200});
  error.SetPlace({"scale.lua", 41});
  Fault fault = FaultOf("axis.inner", error);
  fault.samples.axes.push_back(
      {"inner", {10, 1.5, true, true, false, 7}, {{11, 12, 13, 14, 2.5}, {21, 22, 23, 24, 3.5}}});
  fault.samples.gyro.push_back({1, 2, 30, {4, 5, 6}, {7, 8, 9}, 25.5});
  fault.left = {"heater: off"};
  const json expected = json::parse(R"({
    "source": "axis.inner", "message": "scale.lua:41: exception 03",
    "device": {"name": "axis.inner drive", "action": "move", "code_kind": "modbus_exception",
               "code": 3, "address": 25088},
    "script": {"file": "scale.lua", "line": 41},
    "last_samples": {
      "axes": [{"axis": "inner",
                "drive": {"utime": 10, "commanded_deg": 1.5, "enabled": true, "moving": true,
                          "alarm": 7},
                "reference": [{"utime": 11, "angle_deg": 2.5}, {"utime": 21, "angle_deg": 3.5}]}],
      "gyro": [{"utime": 30, "gyro_lsb": [4, 5, 6], "accel_lsb": [7, 8, 9],
                "temperature_degC": 25.5}]},
    "left": ["heater: off"]})");
  EXPECT_EQ(ToJson(fault), expected);
}

TEST(Fault, OfAForeignExceptionHasItsWordsAlone) {
  const json object = ToJson(FaultOf("record", std::runtime_error("disk full")));
  EXPECT_EQ(object, json::parse(R"({"source": "record", "message": "disk full", "device": null,
                                    "script": null, "last_samples": null, "left": []})"));
}

TEST(Fault, OfSeveralErrorsHasAllWordsAndTheFirstFields) {
  Fault fault{"stop", ""};
  AddTo(fault, std::runtime_error("first"));
  AddTo(fault, DeviceError("second", {.device = "axis.outer drive"}));
  AddTo(fault, DeviceError("third", {.device = "axis.inner drive"}));
  EXPECT_EQ(fault.message, "first; second; third");
  EXPECT_EQ(fault.failure.device, "axis.outer drive");
}

TEST(Fault, SaysNothingTwice) {
  Fault fault{"axis.inner", ""};
  AddTo(fault, DeviceError("axis.inner drive: no answer", {.device = "axis.inner drive"}));
  AddTo(fault, DeviceError("axis.inner drive: no answer", {.device = "axis.inner drive"}));
  EXPECT_EQ(TextOf(fault), "axis.inner drive: no answer");
  EXPECT_EQ(WithSource("record", "the disk is full"), "record: the disk is full");
  EXPECT_EQ(WithSource("axis.in", "axis.inner drive: no answer"),
            "axis.in: axis.inner drive: no answer");
}

// The nearest to the cause knows best.
TEST(Error, KeepsTheFirstPlaceThatItWasGiven) {
  DataError error("disk full");
  EXPECT_STREQ(error.what(), "disk full");
  error.SetPlace({"scale.lua", 41});
  error.SetPlace({"other.lua", 1});
  EXPECT_STREQ(error.what(), "scale.lua:41: disk full");
  EXPECT_EQ(error.place()->line, 41);
}

}  // namespace
}  // namespace gyrobench::daemon
