#include "server/http/head_check.h"

#include <gtest/gtest.h>

namespace isochor {
namespace {

/// 200 when the head passes, else the refusal's status.
int status(const std::string& head) {
  const auto checked = check_head(head);
  const auto* refusal = std::get_if<Refusal>(&checked);
  return refusal ? refusal->status : 200;
}

std::string get(const std::string& fields) {
  return "GET / HTTP/1.1\r\n" + fields + "\r\n";
}

std::string post(const std::string& fields) {
  return "POST / HTTP/1.1\r\n" + fields + "\r\n";
}

TEST(HeadCheck, AnHonestHeadPassesAndIsReadAsItStands) {
  const auto checked =
      check_head("POST /a%20b?x=1 HTTP/1.1\r\nHost: h:1\r\nContent-Length:  12 \r\nEMPTY:\r\n\r\n");
  ASSERT_TRUE(std::holds_alternative<Head>(checked));
  const Head& head = std::get<Head>(checked);
  EXPECT_EQ(head.method, "POST");
  EXPECT_EQ(head.target, "/a%20b?x=1");
  EXPECT_EQ(*head.field("host"), "h:1");
  EXPECT_EQ(*head.field("empty"), "");
  EXPECT_EQ(head.content_length, 12U);
}

TEST(HeadCheck, NothingThatFramesABodyTwice) {
  EXPECT_EQ(status(post("Transfer-Encoding: chunked\r\n")), 411);
  EXPECT_EQ(status(post("Transfer-Encoding: identity\r\nContent-Length: 3\r\n")), 411);
  EXPECT_EQ(status(post("transfer-ENCODING:\tchunked\r\n")), 411);
  EXPECT_EQ(status(post("Content-Length: 3\r\nContent-Length: 3\r\n")), 400);
  EXPECT_EQ(status(post("Content-Length: 3\r\ncontent-length: 4\r\n")), 400);
  for (const char* length : {"3,3", "+3", "-1", "0x3", "3 3", "", "3;"})
    EXPECT_EQ(status(post("Content-Length: " + std::string(length) + "\r\n")), 400) << length;
  EXPECT_EQ(status(post("Content-Length: 99999999999999999999999\r\n")), 413);
}

TEST(HeadCheck, NoBodyWhereNoneBelongs) {
  for (const char* method : {"GET", "HEAD", "DELETE", "OPTIONS", "TRACE"})
    EXPECT_EQ(status(std::string(method) + " / HTTP/1.1\r\nContent-Length: 5\r\n\r\n"), 400) << method;
  EXPECT_EQ(status(get("Content-Length: 0\r\n")), 200);
}

TEST(HeadCheck, NoLineThatTwoReadersCutDifferently) {
  EXPECT_EQ(status("GET / HTTP/1.1\nHost: a\n\r\n\r\n"), 400);
  EXPECT_EQ(status(get("A: b\nC: d\r\n")), 400);
  EXPECT_EQ(status(get("A: b\rC: d\r\n")), 400);
  EXPECT_EQ(status(get("A: b\r\n folded\r\n")), 400);
  EXPECT_EQ(status(get("A : b\r\n")), 400);
  EXPECT_EQ(status(get(": b\r\n")), 400);
  EXPECT_EQ(status(get("no colon\r\n")), 400);
  EXPECT_EQ(status(get(std::string("A: b\0c\r\n", 8))), 400);
  EXPECT_EQ(status(get("A\x80: b\r\n")), 400);
}

TEST(HeadCheck, OnlyOneFormOfRequestLine) {
  for (const char* line : {"GET /",
                           "GET  / HTTP/1.1",
                           "GET / HTTP/1.1 ",
                           " GET / HTTP/1.1",
                           "GET https://h/ HTTP/1.1",
                           "GET http:/h/ HTTP/1.1",
                           "GET http:// HTTP/1.1",
                           "GET http:///h HTTP/1.1",
                           "GET http://?h HTTP/1.1",
                           "GET ftp://h/ HTTP/1.1",
                           "GET //h/http://h HTTP/1.1 x",
                           "GET h:1 HTTP/1.1",
                           "GET http://h/#f HTTP/1.1",
                           "GET http://a b/ HTTP/1.1",
                           "GET http://h@h/ HTTP/1.1",
                           "GET http://h/%zz HTTP/1.1",
                           "GET * HTTP/1.1",
                           "GET /a b HTTP/1.1",
                           "GET /a#b HTTP/1.1",
                           "G\tT / HTTP/1.1",
                           "GET /\x01 HTTP/1.1",
                           "GET /%zz HTTP/1.1",
                           "GET /%0 HTTP/1.1",
                           "GET /a%00b HTTP/1.1",
                           "GET / http/1.1",
                           ""})
    EXPECT_EQ(status(std::string(line) + "\r\n\r\n"), 400) << line;
  EXPECT_EQ(status("GET / HTTP/1.0\r\n\r\n"), 505);
  EXPECT_EQ(status("GET / HTTP/2.0\r\n\r\n"), 505);
  EXPECT_EQ(status("PRI * HTTP/2.0\r\n\r\n"), 505);
  EXPECT_EQ(status("GET /" + std::string(5000, 'a') + " HTTP/1.1\r\n\r\n"), 414);
}

TEST(HeadCheck, AnAbsoluteTargetIsItsAuthorityAndItsPath) {
  const auto read = [](const std::string& target) {
    const auto checked = check_head("GET " + target + " HTTP/1.1\r\nHost: a\r\n\r\n");
    const Head head = std::get<Head>(checked);
    return std::pair(head.authority, head.target);
  };
  using Parts = std::pair<std::string, std::string>;
  EXPECT_EQ(read("http://h:1/a%20b?x=1"), Parts("h:1", "/a%20b?x=1"));
  EXPECT_EQ(read("HTTP://H:1/A"), Parts("h:1", "/A"));
  EXPECT_EQ(read("http://h"), Parts("h", "/"));
  EXPECT_EQ(read("http://h?x=1"), Parts("h", "/?x=1"));
  EXPECT_EQ(read("http://h:1//h"), Parts("h:1", "//h"));
  EXPECT_EQ(read("//h/"), Parts("", "//h/"));
  EXPECT_EQ(read("/http://h/"), Parts("", "/http://h/"));
}

TEST(HeadCheck, WhatTheServerDoesNotDoIsRefused) {
  EXPECT_EQ(status(get("Range: bytes=0-1\r\n")), 416);
  EXPECT_EQ(status(post("Content-Encoding: gzip\r\nContent-Length: 3\r\n")), 415);
  EXPECT_EQ(status(post("Expect: 200-maybe\r\nContent-Length: 3\r\n")), 417);
  EXPECT_EQ(status(post("Expect: 100-Continue\r\nContent-Length: 3\r\n")), 200);
}

TEST(HeadCheck, NamesAreShort) {
  const std::string longest(max_name_bytes, 'a');
  EXPECT_EQ(status(get(longest + ": b\r\n")), 200);
  EXPECT_EQ(status(get(longest + "a: b\r\n")), 431);
  EXPECT_EQ(status(longest + "a / HTTP/1.1\r\n\r\n"), 400);
}

TEST(HeadCheck, HeaderLinesAreCounted) {
  std::string fields;
  for (std::size_t i = 0; i < max_fields; ++i) fields += "A: b\r\n";
  EXPECT_EQ(status(get(fields)), 200);
  EXPECT_EQ(status(get(fields + "A: b\r\n")), 431);
}

TEST(HeadCheck, TheEndIsFoundWhereverTheBytesAreCut) {
  const std::string head = get("Host: a\r\n"), bytes = head + "GET /next";
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    const std::size_t expected = cut < head.size() ? std::string::npos : head.size();
    EXPECT_EQ(head_length(bytes.substr(0, cut)), expected);
    if (cut >= head.size()) {
      EXPECT_EQ(head_length(bytes.substr(0, cut), head.size() - 1), expected);
    }
  }
}

TEST(PercentDecode, EscapesAndTheirFaults) {
  EXPECT_EQ(percent_decode("a%2Fb%c3%A4"), "a/b\xC3\xA4");
  EXPECT_EQ(percent_decode("%41%30"), "A0");
  for (const char* broken : {"%", "%4", "%g0", "%0g", "%00", "a%"})
    EXPECT_EQ(percent_decode(broken), std::nullopt) << broken;
}

}  // namespace
}  // namespace isochor
