#pragma once

#include <filesystem>
#include <string>

#include "harness/study/stress/matrix.hpp"

namespace penumbra::stress {

/// The matrix as a table for people, and below it what is wrong, known or refused, with the
/// figures.
std::string tableText(const Matrix& matrix);
/// case,method,setting,invariant,status,deviation,bound,note; RFC 4180, C locale.
std::string csvText(const Matrix& matrix);
/// One testcase per cell; refused ones are skipped, known ones pass.
std::string junitText(const Matrix& matrix);
/// The document docs/STABILITY.md: the worst deviation of every invariant, the cases, the matrix,
/// the known limitations.
std::string markdownText(const Matrix& matrix);
/// stress.csv, junit.xml and stress.md. Throws InputError where the folder cannot be made.
void writeMatrix(const Matrix& matrix, const std::filesystem::path& folder);

}  // namespace penumbra::stress
