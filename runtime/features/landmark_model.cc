// Models of landmarks as bytes.
#include <sodium.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "runtime/features/landmark_classifier.h"

namespace landfix::features {
namespace {

static_assert(std::endian::native == std::endian::little, "models are little-endian, and so is every target");

constexpr std::array<uint8_t, 8> kMagic = {'L', 'F', 'L', 'M', 'A', 'R', 'K', '\n'};
constexpr uint32_t kVersion = 1;
constexpr size_t kHashBytes = 32;
constexpr size_t kHashAt = kMagic.size() + 2 * sizeof(uint32_t);
constexpr size_t kBodyAt = kHashAt + kHashBytes;

using Hash = std::array<uint8_t, kHashBytes>;

bool hash_of(std::span<const uint8_t> bytes, Hash& hash) {
  return sodium_init() >= 0 &&
         crypto_generichash(hash.data(), hash.size(), bytes.data(), bytes.size(), nullptr, 0) == 0;
}

class Writer {
 public:
  template <typename T>
  void put(const T& value) {
    const auto* p = reinterpret_cast<const uint8_t*>(&value);
    bytes.insert(bytes.end(), p, p + sizeof(T));
  }
  void put(const cv::Mat& values) {
    const auto* p = values.ptr<uint8_t>();
    bytes.insert(bytes.end(), p, p + values.total() * sizeof(float));
  }
  std::vector<uint8_t> bytes;
};

class Reader {
 public:
  explicit Reader(std::span<const uint8_t> bytes) : rest_(bytes) {}
  bool take(void* out, size_t size) {
    if (size > rest_.size()) return false;
    std::memcpy(out, rest_.data(), size);
    rest_ = rest_.subspan(size);
    return true;
  }
  template <typename T>
  bool take(T& value) {
    return take(&value, sizeof(T));
  }
  /// Finite numbers alone.
  bool take_floats(float* out, size_t count) {
    if (!take(out, count * sizeof(float))) return false;
    for (size_t i = 0; i < count; ++i)
      if (!std::isfinite(out[i])) return false;
    return true;
  }
  bool done() const { return rest_.empty(); }

 private:
  std::span<const uint8_t> rest_;
};

struct BagSizes {
  uint16_t texture_words = 0, colour_words = 0, texture_dims = 0, colour_dims = 0;
};

void put_bag(const LandmarkBag& bag, Writer& writer) {
  writer.put(BagSizes{uint16_t(bag.texture.words()), uint16_t(bag.colour.words()), uint16_t(bag.texture.dims()),
                      uint16_t(bag.colour.dims())});
  writer.put(bag.texture.centres());
  writer.put(bag.colour.centres());
  writer.put(bag.weights);
  writer.put(bag.bias);
  writer.put(bag.platt_a);
  writer.put(bag.platt_b);
}

bool take_vocabulary(Reader& reader, int words, int dims, Vocabulary& vocabulary) {
  if (words < 1 || words > kMostWords) return false;
  cv::Mat centres(words, dims, CV_32FC1);
  if (!reader.take_floats(centres.ptr<float>(), centres.total())) return false;
  vocabulary = Vocabulary(centres);
  return true;
}

bool take_bag(Reader& reader, int colour_dims, LandmarkBag& bag) {
  BagSizes sizes;
  if (!reader.take(sizes) || sizes.texture_dims != kTextureDims || sizes.colour_dims != colour_dims) return false;
  if (!take_vocabulary(reader, sizes.texture_words, kTextureDims, bag.texture) ||
      !take_vocabulary(reader, sizes.colour_words, colour_dims, bag.colour))
    return false;
  bag.weights.create(bag.features(), int(kWeightColumns), CV_32FC1);
  return reader.take_floats(bag.weights.ptr<float>(), bag.weights.total()) &&
         reader.take_floats(bag.bias.data(), kTrainedLabels) &&
         reader.take_floats(bag.platt_a.data(), kTrainedLabels) &&
         reader.take_floats(bag.platt_b.data(), kTrainedLabels);
}

}  // namespace

std::vector<uint8_t> encode_model(const LandmarkModel& model) {
  Writer writer;
  writer.put(kMagic);
  writer.put(kVersion);
  writer.put(uint32_t(0));
  writer.put(Hash{});
  put_bag(model.colour, writer);
  put_bag(model.gray, writer);
  std::vector<uint8_t>& bytes = writer.bytes;
  const auto length = uint32_t(bytes.size());
  std::memcpy(&bytes[kMagic.size() + sizeof(uint32_t)], &length, sizeof(length));
  Hash hash{};
  CV_Assert(hash_of(std::span(bytes).subspan(kBodyAt), hash));
  std::memcpy(&bytes[kHashAt], hash.data(), hash.size());
  return bytes;
}

ClassifierStatus decode_model(std::span<const uint8_t> bytes, LandmarkModel& model) noexcept {
  try {
    Reader head(bytes);
    std::array<uint8_t, 8> magic;
    uint32_t version = 0, length = 0;
    Hash stated, found;
    if (!head.take(magic) || magic != kMagic) return ClassifierStatus::kNotAModel;
    if (!head.take(version) || !head.take(length) || !head.take(stated)) return ClassifierStatus::kDamaged;
    if (version != kVersion) return ClassifierStatus::kOtherVersion;
    if (length != bytes.size()) return ClassifierStatus::kDamaged;
    if (!hash_of(bytes.subspan(kBodyAt), found)) return ClassifierStatus::kInternal;
    if (found != stated) return ClassifierStatus::kDamaged;
    Reader body(bytes.subspan(kBodyAt));
    LandmarkModel read;
    if (!take_bag(body, kColourDims, read.colour) || !take_bag(body, kGrayDims, read.gray) || !body.done())
      return ClassifierStatus::kDamaged;
    model = std::move(read);
    return ClassifierStatus::kOk;
  } catch (...) {
    return ClassifierStatus::kInternal;
  }
}

}  // namespace landfix::features
