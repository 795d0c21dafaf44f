// One program a stand: what two must not share is locked before anything of it is opened.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "config/stand_config.h"

namespace gyrobench::drivers {

// Holds the stand's lines (a serial line by its device, whatever link names it; Modbus TCP by its
// addresses and port), its control socket and its folder of records, until destroyed or the process
// ends, however it does. The lines of a virtual stand are the daemon's own, and are not locked.
//
// Each is a locked file in a folder that all users of the machine share, /run/lock or else /tmp,
// and says who holds it.
class StandLock {
 public:
  // Throws Error that names what is held, by whom (process and control socket), and what to do;
  // nothing of the stand was touched then.
  // `program`: what others are told of who holds them.
  StandLock(const config::StandConfig& stand, const std::string& program);
  ~StandLock();
  StandLock(const StandLock&) = delete;
  StandLock& operator=(const StandLock&) = delete;

 private:
  struct Held {
    std::string key;
    std::filesystem::path file;
    int fd = -1;
  };
  void Take(const std::string& what, const std::string& key, const std::string& holder);
  void Release();

  std::vector<Held> held_;
};

}  // namespace gyrobench::drivers
