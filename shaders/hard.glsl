#include "common/receiver.glsl"
#include "common/light_view.glsl"

#ifdef STAGE_FRAGMENT
void main() {
    vec3 position, normal;
    if (!receives(position, normal)) return;
    LightPoint point = lightPoint(position, normal);
    visibility = point.inFront ? litAt(point, point.uv) : 1.0;
}
#endif
