#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

/// The shell of the HTML pages that runs are shown in: one file that works from disk, without a
/// network, and runs nothing but the scripts in pageFolder() and Chart.js. Its Content-Security-
/// Policy names these by their SHA-256 and forbids all else, so that even text that got into the
/// markup could neither run nor load anything.

/// Where the parts of pages are: markup, styles and scripts. PENUMBRA_PAGES, else the source tree.
std::filesystem::path pageFolder();

/// Data in a page: an element that browsers neither show nor run. pageData() of data.js reads it.
struct PageData {
    std::string id;    ///< of the element: letters, digits, '-'
    std::string type;  ///< MIME type, never that of a script
    std::string text;  ///< must be free of `<`: jsonData() and base64() are
};

/// `json` as data. Text that is no UTF-8 has its bad bytes replaced.
PageData jsonData(const std::string& id, const nlohmann::ordered_json& json);

std::string base64(std::span<const unsigned char> bytes);

/// Files of pageFolder() and what goes with them.
struct PageSource {
    std::string title;                ///< any text
    std::string markup;               ///< the content of <body>
    std::vector<std::string> styles;  ///< after page.css
    std::string script;               ///< a module; joinModules() says what it may import
    bool charts = false;              ///< with Chart.js: the global `Chart`
};

/// The page before and after its bulk data, so that this need not be held in memory twice. Scripts
/// run between the two: they find `data` at once, what follows as soon as it has been read.
struct PageShell {
    std::string head;  ///< the document up to and with `data` and the scripts
    std::string tail;  ///< what closes it
};

/// Throws std::runtime_error where a part cannot be read, a module is malformed or Chart.js (Debian
/// package libjs-chart.js) is not installed.
PageShell pageShell(const PageSource& source, std::span<const PageData> data);

/// One element of data as it stands in the page, for between head and tail. Throws
/// std::invalid_argument if it is not what PageData asks for.
std::string dataElement(const PageData& data);

}  // namespace penumbra
