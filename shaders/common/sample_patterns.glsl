// Point i of n on the unit disc, equal areas (Vogel 1979): radius by area, angle by golden angle.
vec2 vogel(int i, int n) {
    float r = sqrt((float(i) + 0.5) / float(n));
    float theta = float(i) * 2.39996323;
    return r * vec2(cos(theta), sin(theta));
}
