// Probabilities from the values of a classifier.
#pragma once

#include <vector>

namespace landfix::landmarks {

/// Probability = 1 / (1 + exp(a value + b)).
struct Sigmoid {
  double a = 0, b = 0;
};

/// The sigmoid of greatest likelihood with Platt's softened targets (Platt 1999), by Newton's method with a line search
/// (Lin, Lin, Weng 2007). Of no value at all: probability 1/2 everywhere; of one kind alone: nearly its own.
Sigmoid fit_sigmoid(const std::vector<double>& values, const std::vector<bool>& yes);

}  // namespace landfix::landmarks
