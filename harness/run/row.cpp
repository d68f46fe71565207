#include "harness/run/row.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "core/error.hpp"
#include "core/file/atomic_file.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/row_check.hpp"

namespace penumbra {

namespace {

// ---- one field -----------------------------------------------------------------------------

std::string formatField(const std::string& value) {
    return value;
}
std::string formatField(bool value) {
    return value ? "1" : "0";
}
std::string formatField(int value) {
    return fmt::format("{}", value);
}
std::string formatField(std::size_t value) {
    return fmt::format("{}", value);
}
/// fmt's "{}" is the shortest text that reads back as the same double, in the C locale.
std::string formatField(const std::optional<double>& value) {
    return value ? fmt::format("{}", *value) : std::string();
}

template <class Number>
bool parseNumber(const std::string& text, Number& value) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc() && stop == end;
}

/// False if `text` is no such value.
bool parseField(const std::string& text, std::string& value) {
    value = text;
    return true;
}
bool parseField(const std::string& text, bool& value) {
    value = text == "1";
    return value || text == "0";
}
bool parseField(const std::string& text, int& value) {
    return parseNumber(text, value);
}
bool parseField(const std::string& text, std::size_t& value) {
    return parseNumber(text, value);
}
bool parseField(const std::string& text, std::optional<double>& value) {
    value.reset();
    return text.empty() || parseNumber(text, value.emplace());
}

// ---- the columns: name, order, reading and writing, each declared once ------------------------

struct Column {
    std::string_view name;
    bool text;      ///< else a number
    bool measured;  ///< a count or flag that says nothing unless the cell was measured
    std::function<std::string(const Row&)> write;
    std::function<bool(Row&, const std::string&)> read;
};

template <class Field>
Column column(std::string_view name, Field field, bool measured = false) {
    constexpr bool kText =
        std::is_same_v<std::decay_t<std::invoke_result_t<Field, Row&>>, std::string>;
    return {name, kText, measured, [field](const Row& row) { return formatField(field(row)); },
            [field, measured](Row& row, const std::string& text) {
                return (measured && text.empty()) || parseField(text, field(row));
            }};
}

#define FIELD(member)        \
    [](auto& row) -> auto& { \
        return row.member;   \
    }
const std::vector<Column>& columns() {
    static const std::vector<Column> kColumns{
        column("scene", FIELD(scene)),
        column("frame", FIELD(frame)),
        column("method", FIELD(method)),
        column("setting", FIELD(setting)),
        column("params", FIELD(params)),
        column("width", FIELD(width)),
        column("height", FIELD(height)),
        column("status", FIELD(status)),
        column("message", FIELD(message)),
        column("frame_ms", FIELD(frameMs)),
        column("frame_ms_low", FIELD(frameMsLow)),
        column("frame_ms_high", FIELD(frameMsHigh)),
        column("frame_ms_mad", FIELD(frameMsMad)),
        column("repeats", FIELD(repeats), true),
        column("unstable", FIELD(unstable), true),
        column("build_ms", FIELD(buildMs)),
        column("shade_ms", FIELD(shadeMs)),
        column("prepare_ms", FIELD(prepareMs)),
        column("draw_calls", FIELD(drawCalls)),
        column("triangles", FIELD(triangles)),
        column("fragments", FIELD(fragments)),
        column("maps", FIELD(maps)),
        column("light_texels", FIELD(lightTexels)),
        column("texture_mib", FIELD(textureMib)),
        column("rmse", FIELD(metrics.rmse)),
        column("mae", FIELD(metrics.mae)),
        column("bias", FIELD(metrics.bias)),
        column("p99", FIELD(metrics.p99)),
        column("max_error", FIELD(metrics.maxError)),
        column("ssim", FIELD(metrics.ssim)),
        column("flip", FIELD(metrics.flip)),
        column("rmse_lit", FIELD(metrics.rmseLit)),
        column("rmse_penumbra", FIELD(metrics.rmsePenumbra)),
        column("rmse_umbra", FIELD(metrics.rmseUmbra)),
        column("leak_rate", FIELD(metrics.leakRate)),
        column("false_shadow_rate", FIELD(metrics.falseShadowRate)),
        column("noise", FIELD(metrics.noise)),
        column("flicker", FIELD(metrics.flicker)),
        column("scored_pixels", FIELD(metrics.scoredPixels), true),
        column("horizon_pixels", FIELD(metrics.horizonPixels), true),
        column("nonfinite", FIELD(metrics.nonfinite), true),
        column("out_of_range", FIELD(metrics.outOfRange), true),
        column("reference_se", FIELD(metrics.referenceSe)),
        column("effects_simulated", FIELD(effectsSimulated)),
        column("effects_skipped", FIELD(effectsSkipped)),
        column("effects_missing", FIELD(effectsMissing)),
        column("renderer", FIELD(renderer)),
        column("threads", FIELD(threads)),
        column("commit", FIELD(commit)),
        column("rmse_corrected", FIELD(metrics.rmseCorrected)),
        column("penumbra_width_error", FIELD(metrics.penumbraWidthError)),
        column("penumbra_shift", FIELD(metrics.penumbraShift)),
        column("shade_fetches_per_pixel", FIELD(shadeFetchesPerPixel)),
    };
    return kColumns;
}
#undef FIELD

/// One field of a row as it stands in the CSV, before quoting.
std::string fieldOf(const Row& row, const Column& column) {
    std::string field = column.write(row);
    // "0 non-finite pixels" of a cell that never ran would read as a result.
    if (column.measured && row.status != "ok" && field == "0") field.clear();
    return field;
}

/// A file whose very header was cut short, as by a kill right after its creation.
bool isTornHeader(const std::string& text) {
    return (csvHeader() + '\n').starts_with(text);
}

Row parseRow(const CsvRecord& record, const std::vector<std::string>& header,
             const std::string& file) {
    if (record.fields.size() != header.size()) {
        throw InputError(fmt::format("{}:{}: {} fields, expected {}", file, record.line,
                                     record.fields.size(), header.size()));
    }
    static const auto kByName = [] {
        std::map<std::string_view, const Column*> map;
        for (const Column& c : columns()) map[c.name] = &c;
        return map;
    }();
    Row row;
    for (std::size_t i = 0; i < header.size(); ++i) {
        const auto known = kByName.find(header[i]);
        if (known == kByName.end()) continue;
        if (!known->second->read(row, record.fields[i])) {
            throw InputError(fmt::format("{}:{}: column {}: '{}' is not a number", file,
                                         record.line, header[i], record.fields[i]));
        }
    }
    return row;
}

/// Numbers that may be below 0; every other column counts, measures or is a fraction.
constexpr std::array<std::string_view, 4> kSigned = {"bias", "ssim", "penumbra_width_error",
                                                     "penumbra_shift"};

/// Names become names of files and folders.
void refusePath(const std::string& name, std::string_view column, const std::string& at) {
    const bool isPath = name == "." || name == ".." ||
                        name.find_first_of(std::string_view("/\0", 2)) != std::string::npos;
    if (name.empty() || isPath)
        throw InputError(fmt::format("{}: column {}: '{}' is no name", at, column, name));
}

/// Refuses what parses but no run writes; `at` is file:line.
void refuseImpossible(const Row& row, const std::string& at) {
    for (const Column& c : columns()) {
        if (c.text) continue;
        const std::string field = c.write(row);
        double value = 0.0;
        if (field.empty() || !parseNumber(field, value)) continue;
        if (!std::isfinite(value))
            throw InputError(fmt::format("{}: column {}: '{}' is not finite", at, c.name, field));
        if (value < 0.0 && std::ranges::find(kSigned, c.name) == kSigned.end())
            throw InputError(fmt::format("{}: column {}: '{}' is below 0", at, c.name, field));
    }
}

void refuseUnknownStatus(const Row& row, const std::string& at) {
    if (row.status != "ok" && row.status != "failed" && row.status != "unsupported")
        throw InputError(fmt::format("{}: column status: '{}'; valid are ok, failed, unsupported",
                                     at, row.status));
}

using LineOfCell = std::map<std::string, std::size_t>;

void refuseRepeated(LineOfCell& lines, const Row& row, std::size_t line, const std::string& at) {
    const auto [first, isNew] = lines.emplace(row.key(), line);
    if (!isNew)
        throw InputError(
            fmt::format("{}: scene {} frame {} setting {} has a row in line {} already", at,
                        row.scene, row.frame, row.setting, first->second));
}

[[noreturn]] void throwErrno(const std::filesystem::path& path, const char* what) {
    throw std::runtime_error(fmt::format("{}: {}: {}", path.string(), what, std::strerror(errno)));
}

/// The whole text in one write() and onto the disk. What did not fit is taken back, so that the
/// rows before it stay readable.
void appendDurably(int fd, const std::string& text) {
    const off_t before = ::lseek(fd, 0, SEEK_END);
    ssize_t written = 0;
    do {
        written = ::write(fd, text.data(), text.size());
    } while (written < 0 && errno == EINTR);
    if (written != static_cast<ssize_t>(text.size())) {
        const int error = written < 0 ? errno : ENOSPC;
        if (written > 0 && ::ftruncate(fd, before) != 0) {
            throw std::runtime_error("results.csv: cannot take back a row written in part");
        }
        throw std::runtime_error(
            fmt::format("results.csv: cannot append a row: {}", std::strerror(error)));
    }
    if (::fdatasync(fd) != 0) {
        throw std::runtime_error(fmt::format("results.csv: fdatasync: {}", std::strerror(errno)));
    }
}

}  // namespace

std::optional<double> numberInColumn(const Row& row, std::string_view name) {
    const auto column = std::ranges::find(columns(), name, &Column::name);
    if (column == columns().end() || column->text)
        throw std::invalid_argument(fmt::format("no column of numbers: {}", name));
    std::optional<double> value;
    parseField(fieldOf(row, *column), value);
    return value;
}

std::string csvHeader() {
    std::string header;
    for (const Column& c : columns()) {
        if (!header.empty()) header += ',';
        header += c.name;
    }
    return header;
}

std::string toCsv(const Row& row) {
    std::string line;
    for (const Column& c : columns()) {
        if (&c != &columns().front()) line += ',';
        line += csvQuoted(fieldOf(row, c));
    }
    return line;
}

std::string toJson(const Row& row) {
    nlohmann::ordered_json json;
    for (const Column& c : columns()) {
        const std::string field = fieldOf(row, c);
        json[std::string(c.name)] = c.text          ? nlohmann::ordered_json(field)
                                    : field.empty() ? nlohmann::ordered_json()
                                                    : nlohmann::ordered_json::parse(field);
    }
    // A name may be no UTF-8.
    return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

namespace {

/// `check` is given each row and its line.
template <class Check>
std::vector<Row> readRows(const std::filesystem::path& path, Check check) {
    const std::string file = path.string();
    const std::string text = readTextFile(path);
    if (isTornHeader(text)) return {};
    const CsvRecords records = splitCsv(text, file);
    if (records.complete.empty()) throw InputError(file + ":1: no header line");

    const std::vector<std::string>& header = records.complete.front().fields;
    for (const Column& c : columns()) {
        if (std::count(header.begin(), header.end(), c.name) != 1) {
            throw InputError(fmt::format("{}:1: column {} must occur once; the columns are {}",
                                         file, c.name, csvHeader()));
        }
    }
    std::vector<Row> rows;
    for (std::size_t i = 1; i < records.complete.size(); ++i) {
        Row row = parseRow(records.complete[i], header, file);
        check(row, records.complete[i].line);
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace

std::vector<Row> readCsv(const std::filesystem::path& path) {
    return readRows(path, [](const Row&, std::size_t) {});
}

std::vector<Row> readCheckedCsv(const std::filesystem::path& path) {
    LineOfCell lines;
    return readRows(path, [&](const Row& row, std::size_t line) {
        const std::string at = fmt::format("{}:{}", path.string(), line);
        refusePath(row.scene, "scene", at);
        refusePath(row.setting, "setting", at);
        refuseImpossible(row, at);
        refuseRepeated(lines, row, line, at);
    });
}

ResultsTable readResultsTable(const std::filesystem::path& path) {
    const std::string file = path.string();
    const std::string text = readTextFile(path);
    const CsvRecords records = splitCsv(text, file);
    if (records.complete.empty()) throw InputError(file + ":1: no header line");
    if (records.completeBytes != text.size()) {
        const auto cut = text.begin() + static_cast<std::ptrdiff_t>(records.completeBytes);
        throw InputError(fmt::format("{}:{}: the file is cut short within this line", file,
                                     1 + std::count(text.begin(), cut, '\n')));
    }
    const std::vector<std::string>& header = records.complete.front().fields;
    const auto times = [&](std::string_view name) {
        return std::count(header.begin(), header.end(), name);
    };
    ResultsTable table;
    for (const std::string& name : header)
        if (times(name) > 1)
            throw InputError(
                fmt::format("{}:1: column {} occurs {} times", file, name, times(name)));
    for (const Column& c : columns())
        if (times(c.name) == 0) table.absent.emplace_back(c.name);
    for (const char* needed : {"scene", "frame", "method", "setting", "status"})
        if (times(needed) == 0)
            throw InputError(fmt::format("{}:1: column {} is missing; the columns are {}", file,
                                         needed, csvHeader()));

    LineOfCell lines;
    for (std::size_t i = 1; i < records.complete.size(); ++i) {
        const CsvRecord& record = records.complete[i];
        const std::string at = fmt::format("{}:{}", file, record.line);
        Row row = parseRow(record, header, file);
        refuseUnknownStatus(row, at);
        refuseImpossible(row, at);
        refuseRepeated(lines, row, record.line, at);
        table.rows.push_back(std::move(row));
        table.lines.push_back(record.line);
        for (std::size_t column = 0; column < header.size(); ++column)
            if (std::ranges::find(columns(), header[column], &Column::name) == columns().end())
                table.unknown[header[column]].push_back(record.fields[column]);
    }
    return table;
}

CsvAppender::CsvAppender(const std::filesystem::path& path) {
    std::error_code ignored;
    std::size_t keep = 0;
    if (std::filesystem::exists(path, ignored)) {
        const std::string text = readTextFile(path);
        if (!isTornHeader(text) || text.ends_with('\n')) {
            const CsvRecords records = splitCsv(text, path.string());
            std::string header;
            if (!records.complete.empty()) {
                header = fmt::format("{}", fmt::join(records.complete.front().fields, ","));
            }
            if (header != csvHeader()) {
                throw InputError(fmt::format("{}:1: the columns are not this version's: {}",
                                             path.string(), csvHeader()));
            }
            keep = records.completeBytes;
        }
    }
    if (keep == 0) {
        const std::string header = csvHeader() + '\n';
        const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
        if (::access(folder.c_str(), W_OK) != 0)
            throw InputError(fmt::format("{}: {}", path.string(), std::strerror(errno)));
        writeFileAtomically(path, header);
        keep = header.size();
    }
    fd_ = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    if (fd_ < 0) throw InputError(fmt::format("{}: {}", path.string(), std::strerror(errno)));
    try {
        if (::ftruncate(fd_, static_cast<off_t>(keep)) != 0) throwErrno(path, "cannot cut");
    } catch (...) {
        ::close(fd_);
        throw;
    }
}

CsvAppender::~CsvAppender() {
    if (fd_ >= 0) ::close(fd_);
}

void CsvAppender::add(const Row& row) {
    appendDurably(fd_, toCsv(row) + '\n');
}

}  // namespace penumbra
