#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "harness/run/truth.hpp"

namespace penumbra {

/// The truth about a frame, traced beside the window and better the longer nothing moves: 16 and 64
/// rays per pixel at first, then adaptive references of ever smaller standard error down to the
/// options' own, which is the very one that `compare` scores against, then the mean of that and
/// further independent ones.
class ProgressiveReference {
  public:
    struct Question {
        std::shared_ptr<const Scene> scene;
        int index = 0;
        std::shared_ptr<const Tracer> tracer;
        std::shared_ptr<const GBuffer> gbuffer;
        AreaLight light;
        /// Whether the scene has this frame, so that the reference cache may know it and is told.
        bool cached = false;
    };
    struct Estimate {
        std::shared_ptr<const GBuffer> gbuffer;  ///< the question's: what it is an answer to
        Reference reference;
        std::string how;  ///< in words
        /// rms over the penumbra pixels, as the column reference_se; absent where there are none.
        std::optional<double> standardError;
        bool converged = false;  ///< as good as `compare` asks for
    };

    /// `options` as of `compare`; the size is the question's.
    explicit ProgressiveReference(const TruthOptions& options);
    ~ProgressiveReference();
    ProgressiveReference(const ProgressiveReference&) = delete;
    ProgressiveReference& operator=(const ProgressiveReference&) = delete;

    /// Drops what is being traced for a new question, at once.
    void ask(Question question);
    void stop();
    /// Never of an earlier question; null before the first answer.
    std::shared_ptr<const Estimate> latest() const;
    /// Of the estimate in the making, in [0,1]; 1 when there is nothing more to do.
    double progress() const;
    /// Why there is none, where tracing failed.
    std::string error() const;

    /// Independent references that are averaged at the end.
    static constexpr int kMostPasses = 16;

  private:
    void work();
    void answer(const Question& question, std::uint64_t number);
    void publish(std::uint64_t number, Estimate estimate);

    TruthOptions options_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Question> question_;  ///< not begun yet
    std::uint64_t number_ = 0;          ///< of the latest question; older work is abandoned
    bool ending_ = false;
    std::shared_ptr<const Estimate> latest_;
    double progress_ = 1.0;
    std::string error_;
    std::thread worker_;  ///< last: it uses the others
};

/// The mean of independent references of one G-buffer, the standard error that it has.
Reference meanOf(const std::vector<Reference>& passes);

}  // namespace penumbra
