// Point i of n on the unit disc, equal areas (Vogel 1979): radius by area, angle by golden angle.
vec2 vogel(int i, int n) {
    float r = sqrt((float(i) + 0.5) / float(n));
    float theta = float(i) * 2.39996323;
    return r * vec2(cos(theta), sin(theta));
}

// A turn by an angle of the pixel's own: the same in every frame, without pattern between pixels.
mat2 pixelRotation(uvec2 pixel) {
    uint x = pixel.x + 0x9e3779b9u * pixel.y;
    x = (x ^ (x >> 16)) * 0x21f0aaadu;
    x = (x ^ (x >> 15)) * 0xd35a2d97u;
    x ^= x >> 15;
    float angle = float(x >> 8) * (6.28318531 / 16777216.0);
    float c = cos(angle), s = sin(angle);
    return mat2(c, s, -s, c);
}
