#include "server/messages/json_text.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "server/messages/bulk_text.h"
#include "tests/support/typed_array.h"

namespace isochor {
namespace {

std::string base64(std::string_view text) {
  std::string out;
  append_base64(out, std::as_bytes(std::span(text)));
  return out;
}

template <class T>
std::string json(const T& value) {
  std::string out;
  append_json(out, value);
  return out;
}

TEST(JsonText, Base64MeetsTheVectorsOfRfc4648) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(JsonText, Base64ReadsBackForEveryLengthAndByte) {
  std::string bytes;
  for (int i = 0; i < 520; ++i) {
    EXPECT_EQ(test::decode_base64(base64(bytes)), bytes);
    bytes += static_cast<char>(i * 7);
  }
}

TEST(JsonText, NumbersReadBackExactly) {
  for (const double value : {0.0, -0.0, 0.1, 1.0 / 3.0, 1e-300, -1.7976931348623157e308, 5e-324})
    EXPECT_EQ(nlohmann::json::parse(json(value)).get<double>(), value);
  EXPECT_EQ(json(0.1F), "0.1");
  EXPECT_EQ(json(std::numeric_limits<std::int64_t>::min()), "-9223372036854775808");
}

TEST(JsonText, ANumberThatIsNotFiniteIsNull) {
  EXPECT_EQ(json(std::numeric_limits<double>::quiet_NaN()), "null");
  EXPECT_EQ(json(-std::numeric_limits<float>::infinity()), "null");
}

TEST(JsonText, AnyBytesBecomeAValidString) {
  EXPECT_EQ(json(std::string_view("a\"b\\c\n\x01")), R"("a\"b\\c\u000a\u0001")");
  EXPECT_EQ(json(std::string_view("\xC3\xA4\xF0\x9F\x8C\xB3")), "\"\xC3\xA4\xF0\x9F\x8C\xB3\"");
  for (const std::string_view broken :
       {"\xFF", "\xC3", "\xC0\x80", "\xED\xA0\x80", "\xE2\x82", "\xF5\x80\x80\x80"})
    EXPECT_NO_THROW(nlohmann::json::parse(json(broken))) << testing::PrintToString(broken);
}

TEST(JsonText, TypedArraysCarryTheirShape) {
  const std::vector<float> values{1.0F, 2.5F, -3.0F, 0.0F, 1e-7F, 8.0F};
  std::string out;
  append_typed_array<float>(out, values, 3);
  const auto array = nlohmann::json::parse(out);
  EXPECT_EQ(array["dtype"], "float32");
  EXPECT_EQ(array["shape"], nlohmann::json({2, 3}));
  EXPECT_EQ(test::decode_typed_array<float>(array), values);
}

TEST(JsonText, BulkTextIsTheSameInPieces) {
  for (const std::size_t count : {0UL, 1UL, 3071UL, 3072UL, 3073UL, 100000UL}) {
    std::vector<float> values(count);
    std::iota(values.begin(), values.end(), 0.5F);
    std::string expected, taken;
    append_typed_array<float>(expected, values, 0);
    expected = "{\"a\":" + expected + ",\"b\":" + expected + ",\"c\":7}";
    std::size_t longest = 0;
    BulkText out([&](std::string_view piece) {
      taken += piece;
      longest = std::max(longest, piece.size());
    });
    {
      BulkObject object(out);
      object.array<float>("a", std::span<const float>(values), 0);
      object.array<float>("b", count, 0, [&](const auto& put) { std::ranges::for_each(values, put); });
      object.member("c", 7);
    }
    out.pass_on();
    EXPECT_EQ(taken, expected) << count;
    EXPECT_LE(longest, 2 * text_piece_bytes);
  }
}

}  // namespace
}  // namespace isochor
