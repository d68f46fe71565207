#include "harness/exchange/frame_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

/// Rows of a matrix that maps column vectors; glm stores columns.
Json rowsOf(const glm::dmat4& m) {
    Json rows = Json::array();
    for (int r = 0; r < 4; ++r) rows.push_back({m[0][r], m[1][r], m[2][r], m[3][r]});
    return rows;
}

/// To OpenGL's clip space, z from -1 to 1.
glm::dmat4 projectionOf(const Camera& camera, double aspect) {
    const double n = camera.nearM, f = camera.farM;
    glm::dmat4 m(0.0);
    if (camera.kind == Camera::Kind::perspective) {
        m[1][1] = 1.0 / std::tan(0.5 * camera.fovYRad);
        m[0][0] = m[1][1] / aspect;
        m[2][2] = -(f + n) / (f - n);
        m[3][2] = -2.0 * f * n / (f - n);
        m[2][3] = -1.0;
    } else {
        m[1][1] = 1.0 / camera.magY;
        m[0][0] = m[1][1] / aspect;
        m[2][2] = -2.0 / (f - n);
        m[3][2] = -(f + n) / (f - n);
        m[3][3] = 1.0;
    }
    return m;
}

Json cameraOf(const Camera& camera, const glm::dvec3& origin, double aspect) {
    const bool perspective = camera.kind == Camera::Kind::perspective;
    const glm::dvec3 position = camera.position + origin;
    const glm::dmat4 world(glm::dvec4(camera.right, 0), glm::dvec4(camera.up, 0),
                           glm::dvec4(camera.back, 0), glm::dvec4(position, 1));
    Json json;
    json["kind"] = perspective ? "perspective" : "orthographic";
    if (perspective) {
        json["fov_y_rad"] = camera.fovYRad;
        json["fov_y_deg"] = glm::degrees(camera.fovYRad);
    } else {
        json["half_height_m"] = camera.magY;
    }
    json["aspect"] = aspect;
    json["near_m"] = camera.nearM;
    json["far_m"] = camera.farM;
    json["position"] = numbers(position);
    json["right"] = numbers(camera.right);
    json["up"] = numbers(camera.up);
    json["forward"] = numbers(-camera.back);
    json["world_from_camera"] = rowsOf(world);
    json["camera_from_world"] = rowsOf(glm::inverse(world));
    json["projection"] = rowsOf(projectionOf(camera, aspect));
    return json;
}

Json lightOf(const AreaLight& light, const glm::dvec3& origin) {
    Json json;
    json["kind"] = light.isPoint() ? "point" : "rectangle";
    json["centre"] = numbers(light.centre + origin);
    json["half_axis_u"] = numbers(light.halfU * light.axisU);
    json["half_axis_v"] = numbers(light.halfV * light.axisV);
    json["normal"] = numbers(light.normal());
    json["corners"] = Json::array();
    for (const glm::dvec3& corner : light.corners())
        json["corners"].push_back(numbers(corner + origin));
    json["area_m2"] = light.area();
    return json;
}

Json conventions() {
    return {
        {"units", "metres; angles in the unit that the key names"},
        {"axes",
         "right-handed, +Y up as in glTF; all positions are world positions, as in the .glb"},
        {"matrices",
         "lists of rows, applied to column vectors: p_world = world_from_camera p_camera"},
        {"camera",
         "looks along -Z of its own frame, +Y up in the image; projection maps to OpenGL clip "
         "space, "
         "z from -1 to 1; near and far cut off nothing that is seen"},
        {"images",
         "the top row comes first; the camera ray of pixel (column x, row y) goes through the "
         "pixel's centre (x + 0.5, y + 0.5), one ray a pixel, no filter"},
        {"light",
         "centre and half axes: points are centre + s half_axis_u + t half_axis_v with s, t in "
         "[-1, 1]; it emits with equal radiance on the side of normal (u cross v) only, casts no "
         "shadow and must not be seen by the camera"},
        {"visibility",
         "V: the fraction of the light's area that nothing hides from the pixel's surface point, "
         "by "
         "area, without cosines; 1 fully lit, 0 umbra"},
        {"casters",
         "every triangle casts and receives, on both sides; where a material is alpha-masked it is "
         "absent below alphaCutoff (base level of the texture, bilinear unless its sampler says "
         "nearest)"},
        {"scored_pixels",
         "only pixels of class 1 enter the error means; an image may hold anything elsewhere"},
        {"scoring", "float values are linear; write V in one channel named visibility"},
    };
}

}  // namespace

std::string frameJson(const TracedFrame& traced, const Camera& camera, const TruthOptions& options,
                      const FrameFiles& files) {
    const Scene& scene = *traced.scene;
    const int width = traced.gbuffer.width, height = traced.gbuffer.height;
    Json json;
    json["scene"] = scene.id;
    json["shows"] = scene.shows;
    json["frame"] = traced.index;
    json["time_s"] = traced.frame.timeS;
    json["width"] = width;
    json["height"] = height;
    json["seed"] = options.seed;
    json["reference"] = options.reference;
    json["reference_se"] = options.referenceSe;
    json["files"] = {
        {"geometry", files.glb}, {"gbuffer", files.gbuffer}, {"reference", files.reference}};
    json["chosen"] = scene.chosen;
    json["camera"] = cameraOf(camera, scene.origin, static_cast<double>(width) / height);
    json["light"] = lightOf(traced.frame.light, scene.origin);
    json["mask"] = {
        {"channel", "mask of the G-buffer"},
        {"0", "background: no surface"},
        {"1", "scored: a surface with the whole light above its tangent plane"},
        {"2", "horizon: part of the light is below the tangent plane; not in the means"},
        {"3", "facing away from the light: V is 0 there, not in the means"}};
    json["conventions"] = conventions();
    // A file's name may be no UTF-8.
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace penumbra
