// Prints every scale factor of the bench: docs/subscribe.md.
#include <cstdio>
#include <lcm/lcm-cpp.hpp>

#include "gyrobench/scale_result_t.hpp"

void Print(const lcm::ReceiveBuffer*, const std::string& channel,
           const gyrobench::scale_result_t* result, std::FILE* to) {
  std::fprintf(to, "%s seq %lld alpha %.9g ± %.2g deg/s per LSB\n", channel.c_str(),
               static_cast<long long>(result->seq), result->alpha_deg_s_per_lsb,
               result->alpha_std_error);
  std::fflush(to);
}

int main(int argc, char** argv) {
  lcm::LCM lcm(argc > 1 ? argv[1] : "udpm://239.255.76.67:7667?ttl=0");
  if (!lcm.good()) return 1;
  lcm.subscribeFunction("GYROBENCH_SCALE_RESULT", Print, stdout)->setQueueCapacity(1000);
  std::puts("listening");
  std::fflush(stdout);
  while (lcm.handle() == 0) {
  }
}
