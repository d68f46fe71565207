#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace penumbra::testing {

/// Where a fuzzer's inputs lie for the loader, which reads files: a folder of this process.
inline const std::filesystem::path& workFolder() {
    static const std::filesystem::path folder = [] {
        auto path =
            std::filesystem::temp_directory_path() / ("penumbra_fuzz_" + std::to_string(getpid()));
        std::filesystem::create_directories(path);
        return path;
    }();
    return folder;
}

inline std::string writeInput(const char* name, const std::uint8_t* data, std::size_t size) {
    const std::filesystem::path path = workFolder() / name;
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    return path.string();
}

}  // namespace penumbra::testing
