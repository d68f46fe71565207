#include "harness/run/csv.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

#include "core/error.hpp"

namespace penumbra {

std::string csvQuoted(const std::string& field) {
    if (field.find_first_of(",\"\r\n") == std::string::npos) return field;
    std::string out = "\"";
    for (const char c : field) {
        if (c == '"') out += '"';
        out += c;
    }
    return out + '"';
}

CsvRecords splitCsv(const std::string& text, const std::string& file) {
    CsvRecords records;
    std::size_t line = 1;
    std::size_t pos = 0;
    while (pos < text.size()) {
        CsvRecord record;
        record.line = line;
        std::string field;
        bool ended = false;
        while (!ended && pos < text.size()) {
            if (text[pos] == '"' && field.empty()) {
                bool open = true;
                for (++pos; open && pos < text.size(); ++pos) {
                    if (text[pos] != '"') {
                        line += text[pos] == '\n';
                        field += text[pos];
                    } else if (pos + 1 < text.size() && text[pos + 1] == '"') {
                        field += text[pos++];
                    } else {
                        open = false;
                    }
                }
                if (open || pos == text.size()) break;
                const bool lineEnd =
                    text[pos] == '\n' || std::string_view("\r\n").starts_with(text.substr(pos, 2));
                if (text[pos] != ',' && !lineEnd) {
                    throw InputError(fmt::format("{}:{}: text after a closing quote in column {}",
                                                 file, line, record.fields.size() + 1));
                }
            }
            const std::size_t stop = text.find_first_of(",\n", pos);
            if (stop == std::string::npos) {
                pos = text.size();
                break;
            }
            std::size_t fieldEnd = stop;
            ended = text[stop] == '\n';
            if (ended && stop > pos && text[stop - 1] == '\r') --fieldEnd;
            field.append(text, pos, fieldEnd - pos);
            record.fields.push_back(std::exchange(field, {}));
            pos = stop + 1;
        }
        if (!ended) break;
        ++line;
        records.complete.push_back(std::move(record));
        records.completeBytes = pos;
    }
    return records;
}

std::string readTextFile(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw InputError(fmt::format("{}: {}", path.string(), std::strerror(errno)));
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace penumbra
