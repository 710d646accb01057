// The binary arithmetic coder with learning models that tiles are coded with: schemas/FORMAT.md section 3.4, codec
// `context`, says what it does bit by bit. Coders of whole tiles are templates over Encoder and Decoder, so that one
// text describes both ways.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace landfix::tiles {

/// How likely a bit is 1, in 1/65536, learned from the bits seen so far: quickly at first, then ever more slowly.
class BitModel {
 public:
  uint32_t probability() const { return probability_; }
  void learn(bool bit) {
    const int rate = std::bit_width(seen_ + 2u) - 1;  // 1 to 7
    if (bit)
      probability_ = uint16_t(probability_ + ((0xFFFF - probability_) >> rate));
    else
      probability_ = uint16_t(probability_ - (probability_ >> rate));
    if (seen_ < kMostSeen) ++seen_;
  }

 private:
  static constexpr uint8_t kMostSeen = 126;
  uint16_t probability_ = 0x8000;
  uint8_t seen_ = 0;
};

/// What encoder and decoder share, without carries: the interval [low, high] of 32 bits is cut at `middle`; leading
/// bytes on which both ends agree are final.
class CodingInterval {
 protected:
  static constexpr uint32_t kEven = 0x8000;  ///< the probability of a bit that no model knows
  uint32_t middle(uint32_t probability) const { return low_ + uint32_t(uint64_t(high_ - low_) * probability >> 16); }
  void cut(uint32_t middle, bool bit) { bit ? high_ = middle : low_ = middle + 1; }
  bool has_final_byte() const { return (low_ ^ high_) >> 24 == 0; }
  uint8_t final_byte() const { return uint8_t(low_ >> 24); }
  void shift() { low_ <<= 8, high_ = high_ << 8 | 0xFF; }

  uint32_t low_ = 0, high_ = 0xFFFFFFFF;
};

class ArithmeticEncoder : CodingInterval {
 public:
  bool code(BitModel& model, bool bit) {
    put(model.probability(), bit);
    model.learn(bit);
    return bit;
  }
  /// A bit that is as likely 1 as 0.
  bool code_even(bool bit) {
    put(kEven, bit);
    return bit;
  }
  bool failed() const { return false; }
  /// Any number of the interval ends the data. The lower end, whole, lets a decoder tell that it is where it should be.
  std::vector<uint8_t> finish() {
    for (int i = 0; i < 4; ++i, shift()) out_.push_back(final_byte());
    return std::move(out_);
  }

 private:
  void put(uint32_t probability, bool bit) {
    cut(middle(probability), bit);
    for (; has_final_byte(); shift()) out_.push_back(final_byte());
  }
  std::vector<uint8_t> out_;
};

/// Reads zeros behind the end of its data; `failed` and `at_end` tell.
class ArithmeticDecoder : CodingInterval {
 public:
  explicit ArithmeticDecoder(std::span<const uint8_t> data) : data_(data) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next();
  }
  /// The bit that was coded; the one given is there for the encoder.
  bool code(BitModel& model, bool) {
    const bool bit = get(model.probability());
    model.learn(bit);
    return bit;
  }
  bool code_even(bool) { return get(kEven); }
  /// Whether it has read beyond the end of its data.
  bool failed() const { return taken_ > data_.size(); }
  /// Whether the encoder would have written the same bytes.
  bool at_end() const { return taken_ == data_.size() && value_ == low_; }

 private:
  bool get(uint32_t probability) {
    const uint32_t cut_at = middle(probability);
    const bool bit = value_ <= cut_at;
    cut(cut_at, bit);
    for (; has_final_byte(); shift()) value_ = value_ << 8 | next();
    return bit;
  }
  uint32_t next() { return taken_ < data_.size() ? data_[taken_++] : (++taken_, 0u); }

  std::span<const uint8_t> data_;
  size_t taken_ = 0;
  uint32_t value_ = 0;
};

}  // namespace landfix::tiles
