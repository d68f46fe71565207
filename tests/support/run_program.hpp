#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>
#include <vector>

/// Runs real programs and keeps what they said.
namespace penumbra::test {

inline std::string readText(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Finished {
    int exitCode = -1;  ///< minus the signal's number when killed
    std::string out, err;
    /// Most memory that it ever had resident; no less than this process's own when it started it.
    double peakMiB = 0.0;
};

/// A program that runs; killed with this object if it still does.
class Program {
  public:
    /// `environment` ("NAME=value") is added to this process's own, of which nothing that would let
    /// a test write outside its folder is handed on.
    explicit Program(std::vector<std::string> command,
                     const std::vector<std::string>& environment = {}) {
        static std::atomic<int> count{0};
        const std::string stem =
            (std::filesystem::temp_directory_path() / "penumbra_program_").string() +
            std::to_string(getpid()) + "_" + std::to_string(++count);
        out_ = stem + ".out";
        err_ = stem + ".err";

        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        const int flags = O_WRONLY | O_CREAT | O_TRUNC;
        posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out_.c_str(), flags, 0600);
        posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err_.c_str(), flags, 0600);
        std::vector<std::string> variables = environment;
        for (char** entry = environ; *entry; ++entry) {
            const std::string variable = *entry;
            const std::string name = variable.substr(0, variable.find('=') + 1);
            bool replaced = name == "GITHUB_STEP_SUMMARY=";
            for (const std::string& own : environment) replaced |= own.starts_with(name);
            if (!replaced) variables.push_back(variable);
        }
        // A shell has its background jobs ignore SIGINT, which programs inherit.
        sigset_t signals;
        sigemptyset(&signals);
        for (const int signal : {SIGINT, SIGTERM}) sigaddset(&signals, signal);
        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        posix_spawnattr_setsigdefault(&attributes, &signals);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
        std::vector<char*> argv = pointers(command), envp = pointers(variables);
        const int error =
            posix_spawn(&pid_, argv[0], &files, &attributes, argv.data(), envp.data());
        posix_spawn_file_actions_destroy(&files);
        posix_spawnattr_destroy(&attributes);
        if (error) throw std::system_error(error, std::generic_category(), command[0]);
    }
    ~Program() {
        if (pid_ > 0) kill(), wait();
    }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    void kill() const { signal(SIGKILL); }
    void signal(int number) const { ::kill(pid_, number); }
    bool runs() const {
        siginfo_t ended{};
        return waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
               ended.si_pid == 0;
    }
    /// What it said on standard error up to now.
    std::string errorsSoFar() const { return readText(err_); }
    Finished wait() {
        int status = 0;
        rusage used{};
        while (wait4(pid_, &status, 0, &used) < 0 && errno == EINTR) {
        }
        pid_ = 0;
        const Finished result{WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status),
                              readText(out_), readText(err_),
                              static_cast<double>(used.ru_maxrss) / 1024.0};
        std::filesystem::remove(out_);
        std::filesystem::remove(err_);
        return result;
    }

  private:
    static std::vector<char*> pointers(std::vector<std::string>& texts) {
        std::vector<char*> list;
        for (std::string& text : texts) list.push_back(text.data());
        list.push_back(nullptr);
        return list;
    }

    pid_t pid_ = 0;
    std::filesystem::path out_, err_;
};

/// `penumbra ARGUMENTS...`
inline std::vector<std::string> penumbraCommand(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), PENUMBRA_PROGRAM);
    return arguments;
}
inline Finished penumbra(std::vector<std::string> arguments,
                         const std::vector<std::string>& environment = {}) {
    return Program(penumbraCommand(std::move(arguments)), environment).wait();
}

inline std::vector<std::string> lines(const std::string& text) {
    std::vector<std::string> list;
    std::size_t begin = 0;
    for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
        list.push_back(text.substr(begin, end - begin));
    if (begin < text.size()) list.push_back(text.substr(begin));
    return list;
}

}  // namespace penumbra::test
