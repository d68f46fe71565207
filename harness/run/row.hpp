#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/metrics/metrics.hpp"

namespace penumbra {

/// One row of results.csv: one cell. Empty optionals are empty fields.
struct Row {
    std::string scene;
    int frame = 0;
    std::string method, setting, params;
    int width = 0, height = 0;
    std::string status = "ok";  ///< ok | failed | unsupported
    std::string message;
    std::optional<double> frameMs, frameMsLow, frameMsHigh, frameMsMad;
    int repeats = 0;
    bool unstable = false;  ///< the 95 % interval is wider than a fifth of the median
    std::optional<double> buildMs, shadeMs, prepareMs;
    std::optional<double> drawCalls, triangles, fragments, maps, lightTexels, textureMib;
    Metrics metrics;
    std::string effectsSimulated, effectsSkipped, effectsMissing;
    std::string renderer;
    int threads = 0;
    std::string commit;
    std::optional<double> shadeFetchesPerPixel;  ///< harness/run/fetch_throughput.hpp

    /// What makes a cell: scene, frame and setting.
    std::string key() const { return scene + '\t' + std::to_string(frame) + '\t' + setting; }
    bool operator==(const Row&) const = default;
};

/// The number in the column called `name`; empty where the field is. Throws std::invalid_argument
/// if there is no such column or it holds text.
std::optional<double> numberInColumn(const Row& row, std::string_view name);

/// Column names in order, joined with commas.
std::string csvHeader();
/// One line without the line end; RFC 4180 quoting, C locale.
std::string toCsv(const Row& row);
/// A JSON object with the columns in order: texts as strings, numbers as in the CSV, null for empty
/// numbers.
std::string toJson(const Row& row);

/// Reads results.csv. A last line cut short by a kill is dropped; any other malformed line throws
/// InputError with file:line. Unknown further columns are ignored, missing ones throw.
std::vector<Row> readCsv(const std::filesystem::path& path);

/// A results.csv that may be of another version or edited by hand, read by column names.
struct ResultsTable {
    std::vector<Row> rows;
    std::vector<std::size_t> lines;   ///< of the file, from 1, where each row starts
    std::vector<std::string> absent;  ///< this version's columns that the file lacks, in order
    /// Columns that this version does not know, each with its field of every row.
    std::map<std::string, std::vector<std::string>> unknown;
};

/// Trusts nothing where readCsv is lenient to a run that was killed: a last line cut short, two
/// rows of one cell, a status that there is not, a number that is not finite or below 0 where it
/// cannot be throw InputError with file:line, as a missing scene, frame, method, setting or status
/// does.
ResultsTable readResultsTable(const std::filesystem::path& path);

/// Appends rows to a results.csv so that each is on disk when add() returns.
class CsvAppender {
  public:
    /// Creates the file with its header, or continues an existing one (cutting a torn last line).
    explicit CsvAppender(const std::filesystem::path& path);
    ~CsvAppender();
    CsvAppender(const CsvAppender&) = delete;
    CsvAppender& operator=(const CsvAppender&) = delete;
    void add(const Row& row);

  private:
    int fd_ = -1;
};

}  // namespace penumbra
