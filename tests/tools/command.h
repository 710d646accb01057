// Runs the program as a user does, through the shell. For test programs that are built with LANDFIX_PROGRAM.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <string>
#include <vector>

namespace landfix::tests {

struct Outcome {
  int code = -1;
  std::string out;  ///< standard output, then standard error
};

/// Standard error goes to a file of the folder; without a name it follows the output.
inline Outcome run_landfix(const std::string& folder, const std::string& arguments, const std::string& errors = "") {
  const std::string command =
      "cd " + folder + " && " LANDFIX_PROGRAM " " + arguments + (errors.empty() ? " 2>&1" : " 2>" + errors);
  Outcome outcome;
  std::FILE* pipe = popen(command.c_str(), "r");
  char buffer[4096];
  for (size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) outcome.out.append(buffer, n);
  const int status = pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

inline void expect_refusal(const Outcome& outcome, int code, const std::vector<std::string>& words) {
  EXPECT_EQ(outcome.code, code) << outcome.out;
  for (const std::string& word : words)
    EXPECT_NE(outcome.out.find(word), std::string::npos) << word << ": " << outcome.out;
}

}  // namespace landfix::tests
