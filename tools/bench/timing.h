// Times and their order statistics.
#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace landfix::bench {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Seconds that `work()` takes.
template <typename Work>
double time_of(Work work) {
  const Clock::time_point start = Clock::now();
  work();
  return seconds_since(start);
}

/// Seconds that `work()` has this thread's core for: what it takes on a core of its own, however busy the machine is.
template <typename Work>
double processor_time_of(Work work) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

/// The value that a share of `share` (0 to 1) of the samples do not exceed; at least one sample.
inline double quantile(std::vector<double> samples, double share) {
  const size_t rank = std::min(samples.size() - 1, size_t(share * double(samples.size())));
  std::nth_element(samples.begin(), samples.begin() + ptrdiff_t(rank), samples.end());
  return samples[rank];
}

inline double median(const std::vector<double>& samples) { return quantile(samples, 0.5); }

}  // namespace landfix::bench
