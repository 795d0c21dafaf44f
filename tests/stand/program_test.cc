// gyrobench-stand as a user starts it: real time, pseudo-terminals, an orderly end.
#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <deque>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace gyrobench {
namespace {

namespace fs = std::filesystem;

class Program {
 public:
  explicit Program(std::deque<std::string> arguments) {
    arguments.emplace_front(GYROBENCH_STAND_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    std::array<int, 2> ends = {};
    if (::pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    if (::posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ) != 0) {
      throw std::runtime_error("cannot start the program");
    }
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    output_ = ::fdopen(ends[0], "r");
  }
  ~Program() {
    if (pid_ > 0) End(SIGKILL);
    std::fclose(output_);
  }
  std::string Line() {
    std::array<char, 512> line = {};
    return std::fgets(line.data(), line.size(), output_) != nullptr ? line.data() : "";
  }
  std::string Rest() {
    std::string all;
    for (std::string line = Line(); !line.empty(); line = Line()) all += line;
    return all;
  }
  // Exit status, or minus the signal that ended it.
  int End(int signal) {
    if (signal != 0) ::kill(pid_, signal);
    int status = 0;
    ::waitpid(std::exchange(pid_, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
  FILE* output_ = nullptr;
};

class StandProgram : public testing::Test {
 protected:
  StandProgram()
      : dir_(fs::temp_directory_path() / ("gyrobench-stand-" + std::to_string(::getpid()))) {
    fs::create_directories(dir_);
  }
  ~StandProgram() override { fs::remove_all(dir_); }
  const std::string config_ = std::string(GYROBENCH_SOURCE_DIR) + "/config/virtual.toml";
  fs::path dir_;
};

TEST_F(StandProgram, ServesEachBusAtThePathThatItPrintsAndLinks) {
  Program program({"--config", config_, "--seed", "7", "--link", dir_.string()});
  for (const std::string name : {"a", "b"}) {
    const std::string line = program.Line();
    EXPECT_EQ(line.rfind("bus " + name + ": /dev/pts/", 0), 0U) << line;
    EXPECT_EQ("bus " + name + ": " + fs::read_symlink(dir_ / ("bus-" + name)).string() + "\n",
              line);
  }
  modbus_t* client = modbus_new_rtu((dir_ / "bus-b").c_str(), 115200, 'N', 8, 1);
  modbus_set_response_timeout(client, 5, 0);
  modbus_set_slave(client, 21);
  ASSERT_EQ(modbus_connect(client), 0);
  std::uint16_t magic = 0;
  EXPECT_EQ(modbus_read_input_registers(client, 0, 1, &magic), 1);
  EXPECT_EQ(magic, 0x4742);
  modbus_close(client);
  modbus_free(client);
  EXPECT_EQ(program.End(SIGTERM), 0);
  EXPECT_FALSE(fs::is_symlink(dir_ / "bus-b"));
}

TEST_F(StandProgram, ServesTcpAtThePortThatItPrints) {
  const fs::path config = dir_ / "stand.toml";
  const std::string maps = std::string(GYROBENCH_SOURCE_DIR) + "/config/devices/";
  std::ofstream(config)
      << "name = \"tcp\"\nprocedures = [\".\"]\ncontrol_socket = \"control.sock\"\n"
         "[bus.t]\ntransport = \"tcp\"\nhost = \"127.0.0.1\"\n"
         "[axis.inner.drive]\nbus = \"t\"\nunit = 3\nmap = \""
      << maps << "leadshine-rs.toml\"\n"
      << "[axis.inner.encoder]\nbus = \"t\"\nunit = 13\nmap = \"" << maps
      << "briter-encoder.toml\"\n"
      << "[gyro]\nbus = \"t\"\nunit = 21\nmap = \"" << maps << "gyro-unit.toml\"\n";
  Program program({"--config", config.string(), "--free-ports"});
  const std::string line = program.Line();
  const std::string head = "bus t: 127.0.0.1:";
  ASSERT_EQ(line.rfind(head, 0), 0U) << line;
  modbus_t* client = modbus_new_tcp("127.0.0.1", std::stoi(line.substr(head.size())));
  modbus_set_response_timeout(client, 5, 0);
  modbus_set_slave(client, 21);
  ASSERT_EQ(modbus_connect(client), 0);
  std::uint16_t magic = 0;
  EXPECT_EQ(modbus_read_input_registers(client, 0, 1, &magic), 1);
  modbus_close(client);
  modbus_free(client);
  EXPECT_EQ(program.End(SIGINT), 0);
}

TEST_F(StandProgram, TakesFaultsFromAFileOfTheirOwnAndWritesTheTruth) {
  std::ofstream(dir_ / "faults.toml")
      << "[[fault]]\ndevice = \"gyro\"\nkind = \"exception\"\namount = 6\n";
  const fs::path truth = dir_ / "truth.csv";
  Program program({"--config", config_, "--link", dir_.string(), "--faults",
                   (dir_ / "faults.toml").string(), "--truth", truth.string()});
  program.Line();
  program.Line();
  modbus_t* client = modbus_new_rtu((dir_ / "bus-b").c_str(), 115200, 'N', 8, 1);
  modbus_set_response_timeout(client, 5, 0);
  modbus_set_slave(client, 21);
  ASSERT_EQ(modbus_connect(client), 0);
  std::uint16_t magic = 0;
  EXPECT_EQ(modbus_read_input_registers(client, 0, 1, &magic), -1);
  EXPECT_EQ(errno, EMBXSBUSY);
  modbus_close(client);
  modbus_free(client);
  EXPECT_EQ(program.End(SIGTERM), 0);
  EXPECT_GT(fs::file_size(truth), 0U);
}

TEST_F(StandProgram, AFileOfFaultsHoldsNothingElse) {
  std::ofstream(dir_ / "faults.toml") << "[gyro]\nscale_rel = [0, 0, 0]\n";
  Program program({"--config", config_, "--faults", (dir_ / "faults.toml").string()});
  const std::string message = program.Rest();
  EXPECT_NE(message.find("faults.toml"), std::string::npos) << message;
  EXPECT_EQ(program.End(0), 1);
}

TEST_F(StandProgram, SaysWhatIsWrongWithAScenarioAndEndsWithAFailure) {
  std::ofstream(dir_ / "bad.toml") << "[gyro]\nscale_rel = 3\n";
  Program program({"--config", config_, "--scenario", (dir_ / "bad.toml").string()});
  const std::string message = program.Rest();
  EXPECT_NE(message.find("bad.toml:2"), std::string::npos) << message;
  EXPECT_EQ(program.End(0), 1);
}

TEST_F(StandProgram, HelpShowsAnExampleAndAMissingFileIsAUsageError) {
  Program help({"--help"});
  EXPECT_NE(help.Rest().find("Example"), std::string::npos);
  EXPECT_EQ(help.End(0), 0);
  Program bare({});
  EXPECT_NE(bare.Rest().find("--config"), std::string::npos);
  EXPECT_EQ(bare.End(0), 2);
}

}  // namespace
}  // namespace gyrobench
