// A host that has Abaqus's message and exit utilities, as Abaqus/Standard does: the UMAT finds and uses them.
#include <gtest/gtest.h>

#include <string>

#include "../support/umat_host.hpp"

namespace {
struct {
  int messages = 0, exits = 0, lop = 0;
  std::string text;
} abaqus;
}  // namespace

extern "C" {
void stdb_abqerr_(const int* lop, const char* text, const int*, const double*, const char*,
                  std::size_t text_length, std::size_t) {
  ++abaqus.messages;
  abaqus.lop = *lop;
  abaqus.text.assign(text, text_length);
}
void xit_() { ++abaqus.exits; }
}

namespace {

TEST(AbaqusHost, GetsTheMessageAndTheExit) {
  host::Call c;
  c.props[4] = 0.9;
  testing::internal::CaptureStderr();
  c.run();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(abaqus.messages, 1);
  EXPECT_EQ(abaqus.lop, -2);
  EXPECT_EQ(abaqus.exits, 1);
  EXPECT_NE(abaqus.text.find("PROPS(5) = 0.9: G_max"), std::string::npos);
  EXPECT_LE(abaqus.text.size(), 500u);                  // Abaqus's limit
  EXPECT_EQ(abaqus.text.find('%'), std::string::npos);  // % would ask for an argument
  EXPECT_TRUE(c.stress.array().isNaN().all());          // should the exit ever return
}

TEST(AbaqusHost, IsNotBotheredByACutBack) {
  abaqus = {};
  host::Call c;
  c.F(0, 0) = -1;
  c.run();
  EXPECT_EQ(c.pnewdt, 0.25);
  EXPECT_EQ(abaqus.messages, 0);
  EXPECT_EQ(abaqus.exits, 0);
}

}  // namespace
