#include "tools/fly/noise.h"

#include <cmath>

namespace landfix::fly {

double NoiseStream::gaussian() {
  // Box-Muller makes two at a time.
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2 * std::log(1 - uniform())), angle = 2 * M_PI * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

}  // namespace landfix::fly
