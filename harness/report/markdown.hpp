#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// What summary.md is written with: GitHub-flavoured Markdown.
namespace penumbra::markdown {

using Cells = std::vector<std::string>;
using Number = std::optional<double>;

/// Text that means itself wherever it stands, in a table cell too.
std::string escaped(std::string_view text);

/// The first `textColumns` columns are aligned left, numbers right. Cells are Markdown already. An
/// empty line follows.
std::string table(const Cells& header, std::size_t textColumns, const std::vector<Cells>& lines);

// Numbers; empty text for an empty number.

/// Three significant digits, whole numbers in full, an exponent only below 0.0001.
std::string number(const Number& value);
std::string whole(const Number& value);
/// 12.3 M and the like.
std::string count(double value);
std::string percent(const Number& fraction);
std::string seconds(double value);

/// Empty unless `whole` is above 0.
Number ratio(double part, double whole);

}  // namespace penumbra::markdown
