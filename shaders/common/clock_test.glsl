// Known work for the self-test of timer queries (core/gl/clock.cpp): `steps` dependent steps for
// every pixel, whose result no compiler can foresee.

#ifdef STAGE_VERTEX
void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.5, 1.0);
}
#endif

#ifdef STAGE_FRAGMENT
uniform int steps;
layout(location = 0) out float value;

void main() {
    float x = gl_FragCoord.x + 0.37 * gl_FragCoord.y;
    for (int i = 0; i < steps; ++i) x = sin(x) * 1.7 + 0.3;
    value = x;
}
#endif
