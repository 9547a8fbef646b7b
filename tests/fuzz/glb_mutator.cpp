#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t header_size = 12, chunk_head_size = 8, framing = header_size + 2 * chunk_head_size;

std::uint32_t word(const std::uint8_t* from) {
  std::uint32_t value = 0;
  std::memcpy(&value, from, sizeof value);
  return value;
}

void append_word(Bytes& out, std::size_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

void append_chunk(Bytes& out, Bytes content, std::uint32_t type, std::uint8_t padding) {
  content.resize((content.size() + 3) / 4 * 4, padding);
  append_word(out, content.size());
  append_word(out, type);
  out.insert(out.end(), content.begin(), content.end());
}

void mutate(Bytes& part, std::size_t most) {
  const std::size_t size = part.size();
  part.resize(std::max({size, most, std::size_t{4}}));  // of no room at all libFuzzer makes nothing
  part.resize(LLVMFuzzerMutate(part.data(), size, part.size()));
}

}  // namespace

/// Most changes to a GLB break nothing but the lengths in its header: mostly one of its chunks is changed,
/// and framed again.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (size < framing || max_size < framing + 8 || seed % 16 == 0)
    return LLVMFuzzerMutate(data, size, max_size);
  const std::size_t length = std::min<std::size_t>(word(data + header_size), size - framing);
  const std::uint8_t *json_begin = data + header_size + chunk_head_size, *json_end = json_begin + length;
  const std::uint8_t *binary_begin = json_end + chunk_head_size, *end = data + size;
  Bytes json(json_begin, json_end), binary(binary_begin, end);
  const std::size_t room = max_size - framing - 8;
  if (seed % 4 != 0)
    mutate(json, room - std::min(room, binary.size()));
  else
    mutate(binary, room - std::min(room, json.size()));

  constexpr std::uint32_t magic = 0x46546c67, version = 2, json_type = 0x4e4f534a, binary_type = 0x004e4942;
  Bytes chunks;
  append_chunk(chunks, std::move(json), json_type, ' ');
  append_chunk(chunks, std::move(binary), binary_type, 0);
  Bytes out;
  append_word(out, magic);
  append_word(out, version);
  append_word(out, header_size + chunks.size());
  out.insert(out.end(), chunks.begin(), chunks.end());
  out.resize(std::min(out.size(), max_size));
  std::copy(out.begin(), out.end(), data);
  return out.size();
}
