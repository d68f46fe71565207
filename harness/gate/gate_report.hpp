#pragma once

#include <string>

#include "harness/gate/judge.hpp"

/// A verdict in the words of each reader. Names in rows may hold anything; every text is escaped
/// for where it goes.
namespace penumbra::gate {

/// For a terminal: what fails with where to look and what to type, then the counts.
std::string verdictText(const Verdict& verdict, const JudgedRun& run);

/// gate.md: a section of summary.md.
std::string verdictMarkdown(const Verdict& verdict, const JudgedRun& run);

/// junit.xml, one testcase per gate. New rows and rows that a rule lets vanish are skipped, missing
/// ones fail with type "missing", all others with type "regression".
std::string verdictJunit(const Verdict& verdict, const JudgedRun& run);

/// GitHub's workflow commands, one `::error` line per failing gate. GitHub shows ten of a step: the
/// tenth line counts the others.
std::string verdictAnnotations(const Verdict& verdict, const JudgedRun& run);

}  // namespace penumbra::gate
