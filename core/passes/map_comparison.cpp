#include "core/passes/map_comparison.hpp"

#include <algorithm>

namespace penumbra {
namespace {

// shaders/adaptive_light_sampled.glsl
constexpr GLuint kBitsUnit = 0, kComparisonsBinding = 0, kCountsBinding = 1;
constexpr GLuint kReceiversImage = 0, kReceiversUnit = 3;
constexpr int kReceiversAcross = 1024, kBlockRows = 4;

/// Rows that hold `count` of the receivers.
int rowsOf(int count) {
    constexpr int kPerBlockRow = kReceiversAcross * kBlockRows;
    return kBlockRows * ((count + kPerBlockRow - 1) / kPerBlockRow);
}

/// At least `bytes` of storage.
void reserve(gl::Buffer& buffer, std::size_t bytes) {
    if (buffer.bytes() < bytes) buffer = gl::Buffer::create(bytes, nullptr, GL_DYNAMIC_STORAGE_BIT);
}

}  // namespace

std::vector<MapComparison> comparisonsOf(const LightTree::Leaf& leaf, bool allPairs) {
    const auto& [a, b, c, d] = leaf.corners;
    std::vector<MapComparison> comparisons;
    if (allPairs) {
        comparisons.push_back({a, b, c, d});
    } else {
        comparisons.push_back({a, d, a, d});
        if (a != b && a != c) comparisons.push_back({b, c, b, c});
    }
    if (leaf.centre >= 0) comparisons.push_back({a, leaf.centre, a, leaf.centre});
    return comparisons;
}

int receiversAmong(const GBuffer& gbuffer, int stride) {
    int receivers = 0;
    for (int row = 0; row < gbuffer.height; row += stride)
        for (int column = 0; column < gbuffer.width; column += stride) {
            const int x = std::min(column + stride / 2, gbuffer.width - 1);
            const int y = std::min(row + stride / 2, gbuffer.height - 1);
            const PixelClass shown =
                gbuffer.mask[static_cast<std::size_t>(y) * static_cast<std::size_t>(gbuffer.width) +
                             static_cast<std::size_t>(x)];
            receivers += isAsked(shown);
        }
    return receivers;
}

BlankTarget::BlankTarget(int width, int height) : width_(width), height_(height) {
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    framebuffer_ = gl::Framebuffer(id);
    glNamedFramebufferParameteri(id, GL_FRAMEBUFFER_DEFAULT_WIDTH, width);
    glNamedFramebufferParameteri(id, GL_FRAMEBUFFER_DEFAULT_HEIGHT, height);
    glCreateVertexArrays(1, &id);
    empty_ = gl::VertexArray(id);
}

void BlankTarget::begin(const GBufferTextures& gbuffer) const {
    constexpr GLuint kPositionUnit = 8, kNormalUnit = 9;  // shaders/common/receiver.glsl
    gbuffer.position.bind(kPositionUnit);
    gbuffer.normal.bind(kNormalUnit);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glViewport(0, 0, width_, height_);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glBindVertexArray(empty_.id());
}

void BlankTarget::draw() const {
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void BlankTarget::end() const {
    glBindVertexArray(0);
    glDisable(GL_SCISSOR_TEST);
}

void QueriedComparison::begin(std::size_t queries) {
    while (queries_.size() < queries) {
        GLuint id = 0;
        glCreateQueries(GL_SAMPLES_PASSED, 1, &id);
        queries_.emplace_back(id);
    }
}

void QueriedComparison::beginQuery(std::size_t query, const TileGrid& tiles, int tile) const {
    if (tiles.count() > 1) {
        glEnable(GL_SCISSOR_TEST);
        glScissor(tile % tiles.columns() * tiles.side, tile / tiles.columns() * tiles.side,
                  tiles.side, tiles.side);
    }
    glBeginQuery(GL_SAMPLES_PASSED, queries_[query].id());
}

void QueriedComparison::endQuery() const {
    glEndQuery(GL_SAMPLES_PASSED);
}

std::vector<std::uint64_t> QueriedComparison::results(std::size_t queries) const {
    std::vector<std::uint64_t> counts;
    for (std::size_t i = 0; i < queries; ++i) {
        GLuint64 passed = 0;
        glGetQueryObjectui64v(queries_[i].id(), GL_QUERY_RESULT, &passed);
        counts.push_back(passed);
    }
    return counts;
}

void CollectedReceivers::collect(const gl::Program& program, const BlankTarget& pixels,
                                 const GBufferTextures& gbuffer) {
    const int rows = rowsOf(pixels.width() * pixels.height());
    if (receivers_.height() != rows)
        receivers_ = gl::Texture::create2D(GL_RGBA32F, kReceiversAcross, rows);
    reserve(counter_, sizeof(GLuint));
    GLuint count = 0;
    glNamedBufferSubData(counter_.id(), 0, sizeof count, &count);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kCountsBinding, counter_.id());
    glBindImageTexture(kReceiversImage, receivers_.id(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    program.set("receiversAcross", kReceiversAcross);
    pixels.begin(gbuffer);
    pixels.draw();
    pixels.end();
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(counter_.id(), 0, sizeof count, &count);
    count_ = static_cast<int>(count);
    const int filled = std::max(1, rowsOf(count_));
    if (rows_.height() != filled) rows_ = BlankTarget(kReceiversAcross, filled);
}

void CollectedReceivers::bind(const gl::Program& program) const {
    receivers_.bind(kReceiversUnit);
    program.set("receiversAcross", kReceiversAcross);
    program.set("receiverCount", count_);
}

ShadowBits::ShadowBits(int width, int height)
    : target_(width, height),
      bits_(gl::Texture::createArray(GL_R32UI, width, height,
                                     static_cast<int>(LightMaps::kMaxSamples / 32))) {}

std::vector<std::uint64_t> ShadowBits::mark(const gl::Program& program,
                                            const GBufferTextures& gbuffer,
                                            std::span<const MapComparison> comparisons,
                                            const TileGrid& tiles) {
    std::vector<GLuint> counts(comparisons.size() * tiles.count());
    const auto bytes = static_cast<GLsizeiptr>(counts.size() * sizeof(GLuint));
    reserve(comparisons_, std::max<std::size_t>(comparisons.size_bytes(), sizeof(MapComparison)));
    reserve(counts_, std::max<std::size_t>(counts.size() * sizeof(GLuint), sizeof(GLuint)));
    if (!comparisons.empty()) {
        glNamedBufferSubData(comparisons_.id(), 0,
                             static_cast<GLsizeiptr>(comparisons.size_bytes()), comparisons.data());
        glNamedBufferSubData(counts_.id(), 0, bytes, counts.data());
    }
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kComparisonsBinding, comparisons_.id());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kCountsBinding, counts_.id());
    program.set("pixelTileSide", tiles.side);
    program.set("pixelTileColumns", tiles.columns());
    program.set("pixelTileCount", static_cast<int>(tiles.count()));
    program.set("comparisonCount", static_cast<int>(comparisons.size()));
    bind();
    target_.begin(gbuffer);
    target_.draw();
    target_.end();
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    if (!counts.empty()) glGetNamedBufferSubData(counts_.id(), 0, bytes, counts.data());
    return {counts.begin(), counts.end()};
}

void ShadowBits::bind() const {
    glBindImageTexture(kBitsUnit, bits_.id(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32UI);
}

}  // namespace penumbra
