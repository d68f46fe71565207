#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace penumbra {

/// A field as RFC 4180 wants it: quoted where it holds a comma, a quote or a line end.
std::string csvQuoted(const std::string& field);

struct CsvRecord {
    std::size_t line = 0;  ///< of the file, from 1, where the record starts
    std::vector<std::string> fields;
};

struct CsvRecords {
    std::vector<CsvRecord> complete;
    std::size_t completeBytes = 0;  ///< what follows is a record cut short
};

/// Splits RFC 4180 text. Only a record with its line end is complete: anything else may have been
/// cut by a kill, even inside a quoted field that holds a newline. Throws InputError naming `file`
/// and line for text after a closing quote.
CsvRecords splitCsv(const std::string& text, const std::string& file);

/// All of a file. Throws InputError with the reason.
std::string readTextFile(const std::filesystem::path& path);

}  // namespace penumbra
