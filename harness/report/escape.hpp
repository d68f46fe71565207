#pragma once

#include <string>
#include <string_view>

/// Text that means itself where it is put, whatever it holds. Bytes that are no UTF-8 and control
/// characters become U+FFFD; CSV, Markdown and JSON have their own (csvQuoted, markdown::escaped,
/// nlohmann).
namespace penumbra {

/// On one line of a terminal.
std::string printable(std::string_view text);
/// In XML and HTML, between tags or in a quoted attribute.
std::string xmlEscaped(std::string_view text);
/// In the message of a GitHub workflow command.
std::string commandData(std::string_view text);
/// In a property of one, as `title`.
std::string commandProperty(std::string_view text);

}  // namespace penumbra
