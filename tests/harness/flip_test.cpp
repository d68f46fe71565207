#include "harness/metrics/flip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>
#include <stdexcept>

namespace penumbra {
namespace {

Image constantImage(int width, int height, float r, float g, float b) {
    Image image = Image::withChannels(width, height, {"R", "G", "B"});
    for (std::size_t i = 0; i < image.pixels.size(); i += 3) {
        image.pixels[i] = r;
        image.pixels[i + 1] = g;
        image.pixels[i + 2] = b;
    }
    return image;
}

Image randomImage(int width, int height, unsigned seed) {
    Image image = constantImage(width, height, 0, 0, 0);
    std::mt19937 generator(seed);
    std::uniform_real_distribution<float> uniform;
    for (float& v : image.pixels) v = uniform(generator);
    return image;
}

double meanFlip(const Image& a, const Image& b) {
    const std::vector<float> errors = flipErrors(prepareFlip(a), prepareFlip(b));
    return std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
}

double greyFlip(float a, float b) {
    return meanFlip(constantImage(24, 20, a, a, a), constantImage(24, 20, b, b, b));
}

// ---- FLIP as its paper and code spell it: sRGB input, two-dimensional kernels, doubles ----------

struct Vec {
    double x, y, z;
};
using Plane = std::vector<double>;
constexpr double kWhiteX = 0.950428545, kWhiteZ = 1.088900371;

Vec xyzFromRgb(const Vec& c) {
    return {(10135552 * c.x + 8788810 * c.y + 4435075 * c.z) / 24577794,
            (2613072 * c.x + 8788810 * c.y + 887015 * c.z) / 12288897,
            (1425312 * c.x + 8788810 * c.y + 70074185 * c.z) / 73733382};
}

/// Cramer's rule on the matrix above.
Vec rgbFromXyz(const Vec& xyz) {
    const Vec r = xyzFromRgb({1, 0, 0}), g = xyzFromRgb({0, 1, 0}), b = xyzFromRgb({0, 0, 1});
    const auto det = [](const Vec& p, const Vec& q, const Vec& s) {
        return p.x * (q.y * s.z - q.z * s.y) - q.x * (p.y * s.z - p.z * s.y) +
               s.x * (p.y * q.z - p.z * q.y);
    };
    const double d = det(r, g, b);
    return {det(xyz, g, b) / d, det(r, xyz, b) / d, det(r, g, xyz) / d};
}

struct Definition {
    int width, height;
    Plane lightness, a, b, edges, points;

    using Kernel = std::function<double(int, int)>;

    double filtered(const Plane& plane, const Kernel& kernel, int radius, int x, int y) const {
        double sum = 0;
        for (int v = -radius; v <= radius; ++v) {
            for (int u = -radius; u <= radius; ++u) {
                const int px = std::clamp(x + u, 0, width - 1);
                const int py = std::clamp(y + v, 0, height - 1);
                sum += kernel(u, v) * plane[static_cast<std::size_t>(py * width + px)];
            }
        }
        return sum;
    }

    /// `kernel` with its positive and its negative values each scaled to sum to 1 in size.
    static Kernel lobesNormalised(const Kernel& kernel, int radius) {
        double positive = 0, negative = 0;
        for (int v = -radius; v <= radius; ++v)
            for (int u = -radius; u <= radius; ++u)
                (kernel(u, v) > 0 ? positive : negative) += std::abs(kernel(u, v));
        return [=](int u, int v) {
            const double k = kernel(u, v);
            return k > 0 ? k / positive : k < 0 ? k / negative : 0.0;
        };
    }

    explicit Definition(const Image& linear) : width(linear.width), height(linear.height) {
        const double ppd = 0.7 * 3840 / 0.7 * std::numbers::pi / 180;
        constexpr double kPi2 = std::numbers::pi * std::numbers::pi;
        const std::size_t size = linear.pixels.size() / 3;
        Plane luminance(size), cx(size), cz(size), forFeatures(size);
        for (std::size_t i = 0; i < size; ++i) {
            const Vec xyz = xyzFromRgb(
                {linear.pixels[3 * i], linear.pixels[3 * i + 1], linear.pixels[3 * i + 2]});
            const double x = xyz.x / kWhiteX, y = xyz.y, z = xyz.z / kWhiteZ;
            luminance[i] = 116 * y - 16;
            cx[i] = 500 * (x - y);
            cz[i] = 200 * (y - z);
            forFeatures[i] = (luminance[i] + 16) / 116;
        }

        const int blur = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi2)) * ppd));
        EXPECT_EQ(blur, 10);
        const auto csf = [&](double a1, double b1, double a2, double b2) {
            return lobesNormalised(
                [=](int u, int v) {
                    const double d2 = (u * u + v * v) / (ppd * ppd);
                    return a1 * std::sqrt(std::numbers::pi / b1) * std::exp(-kPi2 * d2 / b1) +
                           a2 * std::sqrt(std::numbers::pi / b2) * std::exp(-kPi2 * d2 / b2);
                },
                blur);
        };
        const Kernel achromatic = csf(1, 0.0047, 0, 1e-5), redGreen = csf(1, 0.0053, 0, 1e-5);
        const Kernel blueYellow = csf(34.1, 0.04, 13.5, 0.025);

        const double sigma = 0.5 * 0.082 * ppd;
        const int reach = static_cast<int>(std::ceil(3 * sigma));
        EXPECT_EQ(reach, 9);
        const auto gaussian = [=](int u, int v) {
            return std::exp(-(u * u + v * v) / (2 * sigma * sigma));
        };
        const Kernel edgeX =
            lobesNormalised([=](int u, int v) { return -u * gaussian(u, v); }, reach);
        const Kernel pointX = lobesNormalised(
            [=](int u, int v) { return (u * u / (sigma * sigma) - 1) * gaussian(u, v); }, reach);
        const auto turned = [](const Kernel& k) { return [k](int u, int v) { return k(v, u); }; };

        for (auto* plane : {&lightness, &a, &b, &edges, &points}) plane->resize(size);
        for (int py = 0; py < height; ++py) {
            for (int px = 0; px < width; ++px) {
                const auto i = static_cast<std::size_t>(py * width + px);
                const double y = (filtered(luminance, achromatic, blur, px, py) + 16) / 116;
                const double x = y + filtered(cx, redGreen, blur, px, py) / 500;
                const double z = y - filtered(cz, blueYellow, blur, px, py) / 200;
                Vec rgb = rgbFromXyz({x * kWhiteX, y, z * kWhiteZ});
                for (double* c : {&rgb.x, &rgb.y, &rgb.z}) *c = std::clamp(*c, 0.0, 1.0);
                setLab(i, rgb);
                edges[i] = std::hypot(filtered(forFeatures, edgeX, reach, px, py),
                                      filtered(forFeatures, turned(edgeX), reach, px, py));
                points[i] = std::hypot(filtered(forFeatures, pointX, reach, px, py),
                                       filtered(forFeatures, turned(pointX), reach, px, py));
            }
        }
    }

    static Vec huntLab(const Vec& rgb) {
        const auto f = [](double t) {
            const double delta = 6.0 / 29;
            return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
        };
        const Vec xyz = xyzFromRgb(rgb);
        const double fx = f(xyz.x / kWhiteX), fy = f(xyz.y), fz = f(xyz.z / kWhiteZ);
        const double l = 116 * fy - 16;
        return {l, 0.01 * l * 500 * (fx - fy), 0.01 * l * 200 * (fy - fz)};
    }
    void setLab(std::size_t i, const Vec& rgb) {
        const Vec lab = huntLab(rgb);
        lightness[i] = lab.x;
        a[i] = lab.y;
        b[i] = lab.z;
    }

    static double colourError(const Vec& p, const Vec& q) {
        return std::pow(std::abs(p.x - q.x) + std::hypot(p.y - q.y, p.z - q.z), 0.7);
    }

    double against(const Definition& o, std::size_t i) const {
        const double largest = colourError(huntLab({0, 1, 0}), huntLab({0, 0, 1}));
        EXPECT_NEAR(largest, 41.2761, 1e-4);
        const double raw =
            colourError({lightness[i], a[i], b[i]}, {o.lightness[i], o.a[i], o.b[i]});
        const double knee = 0.4 * largest;
        const double colour =
            raw < knee ? 0.95 / knee * raw : 0.95 + (raw - knee) / (largest - knee) * 0.05;
        const double feature =
            std::sqrt(std::max(std::abs(edges[i] - o.edges[i]), std::abs(points[i] - o.points[i])) /
                      std::numbers::sqrt2);
        return std::pow(colour, 1 - std::min(feature, 1.0));
    }
};

TEST(Flip, PublishedValuesOfConstantImages) {
    EXPECT_NEAR(greyFlip(0, 1), 0.967380, 1e-5);
    EXPECT_NEAR(greyFlip(0.5F, 1), 0.53117, 1e-5);
    EXPECT_NEAR(greyFlip(0.9F, 1), 0.15193, 1e-5);
    EXPECT_NEAR(greyFlip(0.1F, 0), 0.73207, 1e-5);
    EXPECT_NEAR(greyFlip(1.0F / 255, 0), 0.13947, 1e-5);
}

TEST(Flip, GreenAgainstBlueIsTheLargestColourDifference) {
    // By definition of cmax: remapped to 1.
    EXPECT_NEAR(meanFlip(constantImage(8, 8, 0, 1, 0), constantImage(8, 8, 0, 0, 1)), 1.0, 1e-5);
}

TEST(Flip, IsTheDefinition) {
    const Image a = randomImage(26, 15, 1), b = randomImage(26, 15, 2);
    const std::vector<float> errors = flipErrors(prepareFlip(a), prepareFlip(b));
    const Definition defA(a), defB(b);
    for (std::size_t i = 0; i < errors.size(); ++i) {
        // Features lie some 1e-7 off in float, and their difference passes through a square root.
        EXPECT_NEAR(errors[i], defA.against(defB, i), 3e-4) << i;
    }
}

TEST(Flip, EqualImagesAreExactlyZero) {
    const Image image = randomImage(31, 17, 3);
    EXPECT_EQ(meanFlip(image, image), 0.0);
}

TEST(Flip, IsSymmetric) {
    const FlipImage a = prepareFlip(randomImage(31, 17, 4)),
                    b = prepareFlip(randomImage(31, 17, 5));
    EXPECT_EQ(flipErrors(a, b), flipErrors(b, a));
}

TEST(Flip, FeaturesAmplifyColourDifferences) {
    // A soft and a hard edge between the same greys: an edge detector sees what a blur hides.
    Image soft = constantImage(40, 40, 0.25F, 0.25F, 0.25F), hard = soft;
    for (int y = 0; y < 40; ++y) {
        for (int x = 0; x < 40; ++x) {
            for (int c = 0; c < 3; ++c) {
                hard.at(x, y, c) = x < 20 ? 0.25F : 0.75F;
                soft.at(x, y, c) =
                    std::clamp(0.25F + 0.5F * (float(x) - 15.0F) / 9.0F, 0.25F, 0.75F);
            }
        }
    }
    const FlipImage a = prepareFlip(soft), b = prepareFlip(hard);
    FlipImage colourOnly = a;
    colourOnly.edges = b.edges;
    colourOnly.points = b.points;
    const std::size_t atEdge = 20 * 40 + 18;
    EXPECT_GT(flipErrors(a, b)[atEdge], flipErrors(colourOnly, b)[atEdge] + 0.01F);
}

TEST(Flip, FeatureOfOneIsGuarded) {
    EXPECT_EQ(combineFlip(0.0F, 1.0F), 0.0F);  // 0^0
    EXPECT_EQ(combineFlip(0.0F, 0.5F), 0.0F);
    EXPECT_EQ(combineFlip(0.25F, 1.0F), 1.0F);
    EXPECT_EQ(combineFlip(0.25F, 0.0F), 0.25F);
    EXPECT_EQ(combineFlip(0.25F, 0.5F), 0.5F);
}

TEST(Flip, InputIsClampedAsADisplayClamps) {
    EXPECT_EQ(greyFlip(-3, 0), 0.0);
    EXPECT_EQ(greyFlip(7, 1), 0.0);
}

TEST(Flip, TinyAndEmptyImages) {
    EXPECT_NEAR(meanFlip(constantImage(1, 1, 0, 0, 0), constantImage(1, 1, 1, 1, 1)), 0.967380,
                1e-5);
    EXPECT_TRUE(prepareFlip(constantImage(0, 0, 0, 0, 0)).colour.empty());
}

TEST(Flip, WrongInputIsRefused) {
    EXPECT_THROW(prepareFlip(Image::withChannels(2, 2, {"V"})), std::invalid_argument);
    EXPECT_THROW(flipErrors(prepareFlip(constantImage(2, 3, 0, 0, 0)),
                            prepareFlip(constantImage(3, 2, 0, 0, 0))),
                 std::invalid_argument);
}

}  // namespace
}  // namespace penumbra
