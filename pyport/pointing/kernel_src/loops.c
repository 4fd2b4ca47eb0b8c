/* Offsets of the RT32's forms and of a table, in loops that a compiler turns into vectors.

   LOOPS names the set. Products and sums are fused only where FUSED says so (no contraction by
   the compiler), so that a point is the same number wherever it stands in an array. The formulae
   are those of pyport.pointing.exact and approximate, arranged as in pyport.pointing.swift; the
   two turns of azimuth are one angle, that of the product of their directions. */

#include "loops.h"
#include "polynomials.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Points of a block: what stands between an angle's sine and the offset stays in the first cache. */
#define BLOCK 128

#ifdef __FP_FAST_FMA
#define FUSED(a, b, c) __builtin_fma(a, b, c)
#else
#define FUSED(a, b, c) ((a) * (b) + (c))
#endif

#define INLINE static inline __attribute__((always_inline))
#define EACH _Pragma("omp simd")

#define PI 0x1.921fb54442d18p+1
#define HALF_PI 0x1.921fb54442d18p+0
#define HALF_PI_LOW 0x1.1a62633145c07p-54
#define DEGREE 0x1.1df46a2529d39p-6

/* pi/2 in three parts of 33 bits, so that products with whole numbers below 2^20 are exact. */
#define HALF_PI_1 0x1.921fb544p+0
#define HALF_PI_2 0x1.0b4611a6p-34
#define HALF_PI_3 0x1.3198a2e037073p-69
/* Larger angles [rad] are left to others. */
#define LARGEST_ANGLE 1e6
/* Added to a number it rounds it to a whole one, which then stands in its last bits. */
#define ROUNDER 0x1.8p52

INLINE double polynomial(const double *coefficient, int terms, double z)
{
    double sum = coefficient[terms - 1];
    for (int n = terms - 2; n >= 0; n--)
        sum = FUSED(sum, z, coefficient[n]);
    return sum;
}

INLINE double magnitude(double x) { return __builtin_fabs(x); }

INLINE double signed_as(double x, double sign) { return __builtin_copysign(x, sign); }

/* Turn the sign where the bit of value two is set. */
INLINE double turned(double x, uint64_t quarters)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits ^= (quarters & 2) << 62;
    memcpy(&x, &bits, sizeof bits);
    return x;
}

INLINE void sine_and_cosine(double angle, double *sine, double *cosine)
{
    double shifted = FUSED(angle, 2 / PI, ROUNDER), whole = shifted - ROUNDER;
    double r = ((angle - whole * HALF_PI_1) - whole * HALF_PI_2) - whole * HALF_PI_3;
    double z = r * r, half = 0.5 * z, near = 1 - half;
    double s = FUSED(r * z, polynomial(SINE, SINE_TERMS, z), r);
    double c = near + FUSED(z * z, polynomial(COSINE, COSINE_TERMS, z), (1 - near) - half);
    uint64_t quarters;
    memcpy(&quarters, &shifted, sizeof quarters);
    int odd = quarters & 1;
    *sine = turned(odd ? c : s, quarters);
    *cosine = turned(odd ? s : c, quarters + 1);
}

/* Of x within a half; z is its square. */
INLINE double small_arcsine(double x, double z)
{
    return FUSED(x * z, polynomial(ARCSINE, ARCSINE_TERMS, z), x);
}

INLINE double arcsine(double x)
{
    double a = magnitude(x), z = 0.5 * (1 - a);
    double large = HALF_PI - (2 * small_arcsine(__builtin_sqrt(z), z) - HALF_PI_LOW);
    return a > 0.5 ? signed_as(large, x) : small_arcsine(x, x * x);
}

INLINE double arctangent(double y, double x)
{
    double up = magnitude(y), along = magnitude(x);
    int steep = up > along;
    double more = steep ? up : along, less = steep ? along : up;
    int middle = less > 0.41421356237309503 * more;
    double above = middle ? less - more : less, below = middle ? less + more : more;
    double t = (below == 0) & (above == 0) ? 0 : above / below, z = t * t;
    double angle = FUSED(t * z, polynomial(ARCTANGENT, ARCTANGENT_TERMS, z), t);
    angle = middle ? HALF_PI / 2 + (angle + HALF_PI_LOW / 2) : angle;
    angle = steep ? HALF_PI - (angle - HALF_PI_LOW) : angle;
    angle = signed_as(1, x) < 0 ? PI - (angle - 2 * HALF_PI_LOW) : angle;
    return signed_as(angle, y);
}

/* What depends on azimuth alone. */
struct azimuths {
    double *sine, *cosine, *across, *along, *curve;
};

INLINE size_t of_azimuths(const double *p, size_t n, const double *az, struct azimuths at)
{
    size_t large = 0;
    _Pragma("omp simd reduction(+ : large)") for (size_t i = 0; i < n; i++)
    {
        double sine, cosine, angle = az[i] - p[TOWARD];
        large += magnitude(angle) > LARGEST_ANGLE;
        sine_and_cosine(angle, &sine, &cosine);
        at.sine[i] = sine;
        at.cosine[i] = cosine;
        at.across[i] = (cosine * p[AZ_BY_SINE] - sine * p[AZ_BY_COSINE]) * sine + p[AZ_ZERO];
        at.along[i] = (cosine * p[ALT_BY_SINE] - sine * p[ALT_BY_COSINE]) * sine + p[ALT_ZERO];
    }
    EACH for (size_t i = 0; i < n; i++)
    {
        /* the altitude of the step: pyport.pointing.jump */
        double sine, cosine, west = (az[i] / DEGREE - 95) / 90;
        sine_and_cosine(az[i] / 2, &sine, &cosine);
        west = (west * west * 15 + 55) * DEGREE;
        at.curve[i] = az[i] <= 0 ? (65 + 7 * cosine) * DEGREE : west;
    }
    return large;
}

/* What depends on altitude alone. */
struct altitudes {
    double *sine, *cosine, *facing, *sag, *height;
};

INLINE size_t of_altitudes(int exact, const double *p, size_t n, const double *alt,
                           struct altitudes at)
{
    size_t large = 0;
    _Pragma("omp simd reduction(+ : large)") for (size_t i = 0; i < n; i++)
    {
        double sine, cosine, h = alt[i];
        large += magnitude(h) > LARGEST_ANGLE;
        sine_and_cosine(h, &sine, &cosine);
        at.sine[i] = sine;
        at.cosine[i] = cosine;
        at.facing[i] = exact ? signed_as(1, cosine) : h > HALF_PI ? -1 : 1;
        at.sag[i] = cosine * p[SAG] + sine * p[SAG_SINE];
        /* below the horizon the step is there whatever the azimuth, on it nowhere */
        at.height[i] = h > 0 ? h : h < 0 ? __builtin_inf() : -__builtin_inf();
    }
    return large;
}

/* Sine and squared cosine of the altitude that the tilted mount reads, and the turn of azimuth
   as an angle's two sides: eqs. 1 to 4. */
struct read {
    double sine, square, turn, dot;
};

INLINE struct read tilted(const double *p, double az_sine, double az_cosine, double sine,
                          double cosine, double facing)
{
    double leaning = cosine * p[LEAN], along = leaning * az_cosine * facing;
    double m = FUSED(along, p[LEAN_SHARE], sine), product = along * m;
    double dot = FUSED(cosine, cosine, -product);
    return (struct read){FUSED(sine, p[UPRIGHT], along),
                         FUSED(m * m, p[LEAN_SQUARED], -product) + dot,
                         leaning * az_sine * m, dot};
}

INLINE double wrapped(double angle)
{
    double turns = __builtin_floor((angle + PI) * (0.5 / PI));
    return angle >= PI || angle < -PI ? angle - turns * (2 * PI) : angle;
}

/* Eqs. 15 and 16: sine and cosine of the turn of azimuth by skew and box, times the cosine of the
   altitude read (the cosine's square may be negative), and the sine of the angle from the true
   altitude to the one that is set. */
struct set {
    double across, square, level, rise;
};

INLINE struct set skewed(const double *p, struct read r, double sine, double cosine, double facing)
{
    double across = FUSED(r.sine, p[ACROSS_BY_SINE], p[ACROSS_ZERO]);
    double square = FUSED(-across, across, r.square);
    double level = __builtin_sqrt(square < 0 ? 0 : square);
    double rise = (r.sine + p[RISE_ZERO]) * (cosine * p[RISE_BY_COSINE])
                  - facing * level * (sine * p[RISE_BY_SINE]);
    return (struct set){across * facing, square, level, rise};
}

INLINE double step(const double *p, double height, double curve)
{
    return height >= curve ? p[JUMP] : 0 * p[JUMP];
}

INLINE void exact_offsets(const double *p, size_t n, struct azimuths az, struct altitudes alt,
                          double *d_az, double *d_alt)
{
    size_t rare = 0;
    _Pragma("omp simd reduction(+ : rare)") for (size_t i = 0; i < n; i++)
    {
        double sine = alt.sine[i], cosine = alt.cosine[i], facing = alt.facing[i];
        struct read r = tilted(p, az.sine[i], az.cosine[i], sine, cosine, facing);
        struct set s = skewed(p, r, sine, cosine, facing);
        double turn = arctangent(r.turn * s.level + s.across * r.dot,
                                 r.dot * s.level - r.turn * s.across);
        rare += (s.square < 0) | (magnitude(s.rise) > 0.5);
        d_az[i] = wrapped(turn + p[SOUTH] * (facing - 1) + az.across[i]);
        d_alt[i] = small_arcsine(s.rise, s.rise * s.rise) + az.along[i] + alt.sag[i]
                   + step(p, alt.height[i], az.curve[i]);
    }
    for (size_t i = 0; rare && i < n; i++)
    {
        double sine = alt.sine[i], cosine = alt.cosine[i], facing = alt.facing[i];
        struct read r = tilted(p, az.sine[i], az.cosine[i], sine, cosine, facing);
        struct set s = skewed(p, r, sine, cosine, facing);
        double change = arcsine(s.rise);
        if (s.square < 0)
        {
            /* no setting reaches the source: the azimuth has stopped */
            double reach = signed_as(__builtin_sqrt(r.square > 0 ? r.square : 0), facing * s.across);
            double up = r.sine + p[ACROSS_BY_SINE] * reach;
            change = arctangent(up * cosine, up * sine);
        }
        if ((s.square < 0) | (magnitude(s.rise) > 0.5))
            d_alt[i] = change + az.along[i] + alt.sag[i] + step(p, alt.height[i], az.curve[i]);
    }
}

INLINE void approximate_offsets(const double *p, size_t n, struct azimuths az,
                                struct altitudes alt, double *d_az, double *d_alt)
{
    /* eqs. 18 and 19 */
    EACH for (size_t i = 0; i < n; i++)
    {
        double across = (az.sine[i] * p[LEAN] + p[SIGMA]) * alt.sine[i] + p[BETA];
        d_az[i] = wrapped(across / alt.cosine[i] + az.across[i]);
        d_alt[i] = az.cosine[i] * p[LEAN] * alt.facing[i] + az.along[i] + alt.sag[i]
                   + step(p, alt.height[i], az.curve[i]);
    }
}

INLINE void offsets(int exact, const double *p, size_t n, struct azimuths az,
                    struct altitudes alt, double *d_az, double *d_alt)
{
    if (exact)
        exact_offsets(p, n, az, alt, d_az, d_alt);
    else
        approximate_offsets(p, n, az, alt, d_az, d_alt);
}

static size_t scattered(int exact, const double *p, size_t n, const double *az, const double *alt,
                        double *d_az, double *d_alt)
{
    double room[10][BLOCK];
    struct azimuths by_az = {room[0], room[1], room[2], room[3], room[4]};
    struct altitudes by_alt = {room[5], room[6], room[7], room[8], room[9]};
    size_t large = 0;
    for (size_t low = 0; low < n; low += BLOCK)
    {
        size_t some = n - low < BLOCK ? n - low : BLOCK;
        large += of_azimuths(p, some, az + low, by_az);
        large += of_altitudes(exact, p, some, alt + low, by_alt);
        offsets(exact, p, some, by_az, by_alt, d_az + low, d_alt + low);
    }
    return large;
}

static size_t grid(int exact, const double *p, size_t columns, const double *az, size_t rows,
                   const double *alt, double *room, double *d_az, double *d_alt)
{
    struct azimuths whole = {room, room + columns, room + 2 * columns, room + 3 * columns,
                             room + 4 * columns};
    size_t large = of_azimuths(p, columns, az, whole);
    double one[5], all[5][BLOCK];
    struct altitudes here = {one, one + 1, one + 2, one + 3, one + 4};
    struct altitudes spread = {all[0], all[1], all[2], all[3], all[4]};
    for (size_t row = 0; row < rows; row++)
    {
        large += of_altitudes(exact, p, 1, alt + row, here);
        for (int k = 0; k < 5; k++)
            EACH for (size_t i = 0; i < BLOCK; i++) all[k][i] = one[k];
        for (size_t low = 0; low < columns; low += BLOCK)
        {
            size_t some = columns - low < BLOCK ? columns - low : BLOCK, at = row * columns + low;
            struct azimuths by_az = {whole.sine + low, whole.cosine + low, whole.across + low,
                                     whole.along + low, whole.curve + low};
            offsets(exact, p, some, by_az, spread, d_az + at, d_alt + at);
        }
    }
    return large;
}

/* From one number to another by a share: at either end exactly what stands there. Minus is the
   number's and not the share's: compilers then subtract the product in one instruction. */
#define BETWEEN(from, to, share) FUSED(share, to, FUSED(-(from), share, from))

static size_t look_up(const struct table *t, size_t n, const double *az, const double *zd,
                      double *d_az, double *d_zd)
{
    double per_az = (double)(t->rows - 1) / (t->last_az - t->first_az);
    double per_zd = (double)(t->row - 1) / (t->last_zd - t->first_zd);
    size_t beyond = 0;
    int32_t cell[BLOCK];
    double east[BLOCK], north[BLOCK];
    for (size_t low = 0; low < n; low += BLOCK)
    {
        size_t some = n - low < BLOCK ? n - low : BLOCK;
        _Pragma("omp simd reduction(+ : beyond)") for (size_t i = 0; i < some; i++)
        {
            double u = az[low + i], v = zd[low + i];
            int inside = (u >= t->first_az) & (u <= t->last_az) & (v >= t->first_zd)
                         & (v <= t->last_zd);
            beyond += !inside;
            u = inside ? (u - t->first_az) * per_az : 0;
            v = inside ? (v - t->first_zd) * per_zd : 0;
            int32_t k = (int32_t)u, m = (int32_t)v;
            k = k < (int32_t)t->rows - 2 ? k : (int32_t)t->rows - 2;
            m = m < (int32_t)t->row - 2 ? m : (int32_t)t->row - 2;
            cell[i] = k * (int32_t)t->row + m;
            east[i] = u - k;
            north[i] = v - m;
        }
        for (size_t i = 0; i < some; i++)
        {
            const double *here = t->offsets + 2 * (size_t)cell[i], *next = here + 2 * t->row;
            double along[4], sum[2];
            EACH for (int c = 0; c < 4; c++) along[c] = BETWEEN(here[c], next[c], east[i]);
            EACH for (int c = 0; c < 2; c++) sum[c] = BETWEEN(along[c], along[2 + c], north[i]);
            d_az[low + i] = sum[0];
            d_zd[low + i] = sum[1];
        }
    }
    return beyond;
}

/* As many numbers as a register of the processor holds, wherever they stand. A wider vector than
   that would live in memory. */
#if defined __AVX512F__
#define LANES 8
#elif defined __AVX__
#define LANES 4
#else
#define LANES 2
#endif
typedef double lanes __attribute__((vector_size(8 * LANES), aligned(8), may_alias));

/* Columns that are multiplied with one at a time: one sum would wait for itself. */
#define BESIDE 4

/* Add to `sums` the products of n numbers with each of so many columns, which are `apart` numbers
   apart in memory. */
static void add_products(size_t n, const double *one, size_t count, const double *columns,
                         size_t apart, double *sums)
{
    const double *of[BESIDE];
    lanes sum[BESIDE];
    size_t whole = n / LANES * LANES;
    for (size_t r = 0; r < BESIDE; r++)
    {
        of[r] = columns + (r < count ? r : 0) * apart;
        sum[r] = (lanes){0};
    }
    for (size_t i = 0; i < whole; i += LANES)
        for (size_t r = 0; r < BESIDE; r++)
            sum[r] += *(const lanes *)(one + i) * *(const lanes *)(of[r] + i);
    for (size_t r = 0; r < count; r++)
    {
        double total = 0;
        for (size_t i = 0; i < LANES; i++)
            total += sum[r][i];
        for (size_t i = whole; i < n; i++)
            total += one[i] * of[r][i];
        sums[r] += total;
    }
}

static void gram(size_t k, size_t n, const double *columns, const double *weight,
                 const double *target, double *normal, double *right)
{
    double heavy[2 * BLOCK];
    for (size_t a = 0; a < k * k; a++)
        normal[a] = 0;
    for (size_t a = 0; a < k; a++)
        right[a] = 0;
    for (size_t low = 0; low < n; low += 2 * BLOCK)
    {
        size_t some = n - low < 2 * BLOCK ? n - low : 2 * BLOCK;
        for (size_t a = 0; a < k; a++)
        {
            const double *column = columns + a * n + low;
            EACH for (size_t i = 0; i < some; i++) heavy[i] = column[i] * weight[low + i];
            for (size_t b = 0; b <= a; b += BESIDE)
                add_products(some, heavy, a - b < BESIDE ? a - b + 1 : BESIDE,
                             columns + b * n + low, n, normal + a * k + b);
        }
        for (size_t b = 0; b < k; b += BESIDE)
            add_products(some, target + low, k - b < BESIDE ? k - b : BESIDE,
                         columns + b * n + low, n, right + b);
    }
    for (size_t a = 0; a < k; a++)
        for (size_t b = 0; b < a; b++)
            normal[b * k + a] = normal[a * k + b];
}

/* The smallest but k of n numbers, which are lost. */
static double ranked(size_t n, double *of, size_t k)
{
    uint64_t chance = 0;
    for (;;)
    {
        /* a pivot by chance: no order of the numbers makes all of them bad */
        chance = chance * 6364136223846793005u + 1442695040888963407u;
        double pivot = of[(chance >> 32) % n];
        size_t below = 0, upto = 0, kept = 0;
        _Pragma("omp simd reduction(+ : below, upto)") for (size_t i = 0; i < n; i++)
        {
            below += of[i] < pivot;
            upto += of[i] <= pivot;
        }
        /* no branch depends on a number: half of them would be mispredicted */
        if (k < below)
            for (size_t i = 0; i < n; i++)
            {
                double one = of[i];
                of[kept] = one;
                kept += one < pivot;
            }
        else if (k >= upto)
            for (size_t i = 0; i < n; i++)
            {
                double one = of[i];
                of[kept] = one;
                kept += one > pivot;
            }
        if (!kept)
            return pivot;
        k -= k < below ? 0 : upto;
        n = kept;
    }
}

static double median(size_t n, const double *values, double *room)
{
    memcpy(room, values, n * sizeof *values);
    double high = ranked(n, room, n / 2), low = -__builtin_inf();
    size_t below = 0;
    _Pragma("omp simd reduction(+ : below) reduction(max : low)") for (size_t i = 0; i < n; i++)
    {
        int less = values[i] < high;
        below += less;
        low = less && values[i] > low ? values[i] : low;
    }
    return n % 2 || below < n / 2 ? high : (low + high) / 2;
}

/* Columns that are whitened at a time: what is carried along of them stays in the first cache. */
#define SIDE_BY_SIDE 128

/* Of every row what each term keeps until then, and what it takes of the row; the variance given the
   rows before. The covariance of Ornstein-Uhlenbeck processes is semiseparable, and so is its
   triangle: Foreman-Mackey et al. 2017, AJ 154, 220. */
static int factored(size_t n, size_t terms, const double *time, const double *rate,
                    const double *power, const double *variance, double *known, double *decay,
                    double *weight, double *d)
{
    double total = 0;
    for (size_t a = 0; a < terms; a++)
        total += power[a];
    for (size_t a = 0; a < terms * terms; a++)
        known[a] = 0;
    for (size_t i = 0; i < n; i++, decay += terms, weight += terms)
    {
        double before = i ? d[i - 1] : 0, left = variance[i] + total;
        const double *last = i ? weight - terms : NULL;
        for (size_t a = 0; a < terms; a++)
            decay[a] = i ? exp(rate[a] * (time[i - 1] - time[i])) : 0;
        for (size_t a = 0; a < terms; a++)
        {
            double sum = 0;
            for (size_t b = 0; i && b < terms; b++)
            {
                double *of = known + a * terms + b;
                *of = decay[a] * (*of + before * last[a] * last[b]) * decay[b];
                sum += power[b] * *of;
            }
            weight[a] = sum;
            left -= sum * power[a];
        }
        if (!(left > 0))
            return 0;
        for (size_t a = 0; a < terms; a++)
            weight[a] = (1 - weight[a]) / left;
        d[i] = left;
    }
    return 1;
}

static int whiten(size_t n, const int64_t *rows, size_t terms, size_t k, const double *time,
                  const double *rate, const double *power, const double *variance,
                  const double *columns, double *room, double *d, double *white)
{
    double *known = room, *decay = known + terms * terms, *weight = decay + n * terms;
    double *carried = weight + n * terms, last[SIDE_BY_SIDE], sum[SIDE_BY_SIDE];
    if (!factored(n, terms, time, rate, power, variance, known, decay, weight, d))
        return 0;
    for (size_t low = 0; low < k; low += SIDE_BY_SIDE)
    {
        size_t some = k - low < SIDE_BY_SIDE ? k - low : SIDE_BY_SIDE;
        for (size_t c = 0; c < terms * SIDE_BY_SIDE; c++)
            carried[c] = 0;
        for (size_t c = 0; c < SIDE_BY_SIDE; c++)
            last[c] = 0;
        for (size_t i = 0; i < n; i++)
        {
            const double *from = columns + (size_t)rows[i] * k + low;
            double *to = white + (size_t)rows[i] * k + low, scale = 1 / __builtin_sqrt(d[i]);
            EACH for (size_t c = 0; c < some; c++) sum[c] = 0;
            for (size_t a = 0; a < terms; a++)
            {
                double share = i ? weight[(i - 1) * terms + a] : 0, fading = decay[i * terms + a];
                double strength = power[a], *of = carried + a * SIDE_BY_SIDE;
                EACH for (size_t c = 0; c < some; c++)
                {
                    of[c] = fading * (of[c] + share * last[c]);
                    sum[c] += strength * of[c];
                }
            }
            EACH for (size_t c = 0; c < some; c++)
            {
                last[c] = from[c] - sum[c];
                to[c] = last[c] * scale;
            }
        }
    }
    return 1;
}

/* Registers that eight numbers take, and rows of a product that are held at a time: eight registers
   add up, of the sixteen that there are at least. */
#define ABREAST (8 / LANES)
#define HELD LANES
/* Rows whose products are added together: they stay in the first cache. */
#define TOGETHER 64

/* Add to the lower half of `sums` (wide, wide) the products of the columns of so many rows. */
static void add_squares(size_t count, size_t wide, const double *rows, double *sums)
{
    for (size_t row = 0; row < wide; row += HELD)
        for (size_t c = 0; c <= row; c += 8)
        {
            lanes sum[HELD][ABREAST];
            for (int r = 0; r < HELD; r++)
                for (int k = 0; k < ABREAST; k++)
                    sum[r][k] = *(lanes *)(sums + (row + (size_t)r) * wide + c + k * LANES);
            for (size_t i = 0; i < count; i++)
            {
                const double *one = rows + i * wide;
                for (int r = 0; r < HELD; r++)
                    for (int k = 0; k < ABREAST; k++)
                        sum[r][k] += one[row + (size_t)r] * *(const lanes *)(one + c + k * LANES);
            }
            for (int r = 0; r < HELD; r++)
                for (int k = 0; k < ABREAST; k++)
                    *(lanes *)(sums + (row + (size_t)r) * wide + c + k * LANES) = sum[r][k];
        }
}

/* What `factored` leaves of n rows and so many terms. */
struct drift {
    size_t n, terms;
    const double *power, *decay, *weight, *d;
};

/* Whiten columns (n, wide), in place; `carried` holds of every eight columns what each term keeps. */
static void forward(struct drift of, size_t wide, double *columns, double *carried)
{
    for (size_t c = 0; c < of.terms * wide; c++)
        carried[c] = 0;
    for (size_t i = 0; i < of.n; i++)
    {
        double *row = columns + i * wide, scale = 1 / __builtin_sqrt(of.d[i]);
        const double *share = of.weight + i * of.terms, *fading = of.decay + (i + 1) * of.terms;
        size_t kept = i + 1 < of.n ? of.terms : 0;
        for (size_t c = 0; c < wide; c += 8)
        {
            lanes left[ABREAST];
            double *from = carried + c * of.terms;
            for (int k = 0; k < ABREAST; k++)
                left[k] = *(const lanes *)(row + c + k * LANES);
            for (size_t a = 0; a < of.terms; a++)
                for (int k = 0; k < ABREAST; k++)
                    left[k] -= of.power[a] * *(const lanes *)(from + 8 * a + k * LANES);
            for (size_t a = 0; a < kept; a++)
                for (int k = 0; k < ABREAST; k++)
                {
                    lanes *one = (lanes *)(from + 8 * a + k * LANES);
                    *one = fading[a] * (*one + share[a] * left[k]);
                }
            for (int k = 0; k < ABREAST; k++)
                *(lanes *)(row + c + k * LANES) = left[k] * scale;
        }
    }
}

/* Make of whitened columns the inverse covariance times the columns, in place. */
static void backward(struct drift of, size_t wide, double *columns, double *carried)
{
    for (size_t c = 0; c < of.terms * wide; c++)
        carried[c] = 0;
    for (size_t i = of.n; i-- > 0;)
    {
        double *row = columns + i * wide, scale = 1 / __builtin_sqrt(of.d[i]);
        const double *share = of.weight + i * of.terms, *fading = of.decay + i * of.terms;
        for (size_t c = 0; c < wide; c += 8)
        {
            lanes left[ABREAST];
            double *from = carried + c * of.terms;
            for (int k = 0; k < ABREAST; k++)
                left[k] = *(const lanes *)(row + c + k * LANES) * scale;
            for (size_t a = 0; a < of.terms; a++)
                for (int k = 0; k < ABREAST; k++)
                    left[k] -= share[a] * *(const lanes *)(from + 8 * a + k * LANES);
            for (size_t a = 0; a < of.terms; a++)
                for (int k = 0; k < ABREAST; k++)
                {
                    lanes *one = (lanes *)(from + 8 * a + k * LANES);
                    *one = fading[a] * (*one + of.power[a] * left[k]);
                }
            for (int k = 0; k < ABREAST; k++)
                *(lanes *)(row + c + k * LANES) = left[k];
        }
    }
}

/* Rows whose numbers are multiplied together. */
#define SOME 16

/* Add to `sums` the products of the numbers of so many rows with the rows of `mixed`, as far as
   columns were met; numbers of one column in several rows are gone through together. */
static void add_few(size_t count, size_t met, size_t wide, const int64_t *starts,
                    const int64_t *places, const double *numbers, const int32_t *order,
                    const double *mixed, double *sums)
{
    int64_t next[SOME];
    for (size_t i = 0; i < count; i++)
        next[i] = starts[i];
    for (size_t i = 0; i < count; i++)
        for (; next[i] < starts[i + 1]; next[i]++)
        {
            const double *rows[SOME];
            double by[SOME], *row = sums + (size_t)order[places[next[i]]] * wide;
            size_t some = 0;
            for (size_t k = i; k < count; k++)
                if (k == i || (next[k] < starts[k + 1] && places[next[k]] == places[next[i]]))
                {
                    by[some] = numbers[next[k]];
                    rows[some++] = mixed + k * wide;
                    next[k] += k != i;
                }
            for (size_t c = 0; c < met; c += LANES)
            {
                lanes *to = (lanes *)(row + c), sum = *to;
                for (size_t k = 0; k < some; k++)
                    sum += by[k] * *(const lanes *)(rows[k] + c);
                *to = sum;
            }
        }
}

/* The products of q columns that are mostly zero, half of them: their sum with its transpose is
   the products. With y a row, f what the rows before keep of it in each term and u the terms'
   variances, the whitened row is (y - u'f) / sqrt(d), and the next row's f is A f + b y. In the
   sum of the rows' products those of f with itself are then those of y with f and with y, by what
   all rows to come make of f: only numbers that are not zero are multiplied, and no column before
   its first. `order` says where each column stands: in the order of their first numbers. */
static void few_products(struct drift of, size_t q, const int64_t *starts, const int64_t *places,
                         const double *numbers, int32_t *order, double *room, double *sums)
{
    size_t wide = WIDE(q), terms = of.terms, held = 0;
    int32_t met = 0;
    const double *power = of.power;
    double *own = room, *other = own + of.n, *rest = other + of.n * terms;
    double *part = rest + terms * terms, *before = part + terms, *mixed = before + terms * wide;
    for (size_t a = 0; a < terms * terms; a++)
        rest[a] = 0;
    for (size_t i = of.n; i-- > 0;)
    {
        const double *w = of.weight + i * terms, *fading = of.decay + (i + 1) * terms;
        double all = 1 / of.d[i];
        for (size_t a = 0; a < terms; a++)
        {
            double sum = 0;
            for (size_t b = 0; i + 1 < of.n && b < terms; b++)
                sum += (rest[a * terms + b] *= fading[a] * fading[b]) * w[b];
            all += w[a] * (part[a] = sum);
        }
        own[i] = 0.5 * all;
        for (size_t a = 0; a < terms; a++)
        {
            other[i * terms + a] = part[a] - power[a] * all;
            for (size_t b = 0; b < terms; b++)
                rest[a * terms + b] +=
                    power[a] * power[b] * all - power[a] * part[b] - part[a] * power[b];
        }
    }
    for (size_t c = 0; c < (terms + SOME) * wide; c++)
        before[c] = 0;
    for (size_t c = 0; c < q; c++)
        order[c] = -1;
    for (size_t i = 0; i < of.n; i++)
    {
        const double *to = other + i * terms, *w = of.weight + i * terms;
        const double *fading = of.decay + (i + 1) * terms;
        double *now = mixed + held * wide;
        size_t kept = i + 1 < of.n ? terms : 0;
        for (size_t at = (size_t)starts[i]; at < (size_t)starts[i + 1]; at++)
            if (order[places[at]] < 0)
                order[places[at]] = met++;
        for (size_t c = 0; c < (size_t)met; c += 8)
        {
            lanes sum[ABREAST], taken[ABREAST];
            double *from = before + c * terms;
            for (int k = 0; k < ABREAST; k++)
                sum[k] = taken[k] = (lanes){0};
            for (size_t a = 0; a < terms; a++)
                for (int k = 0; k < ABREAST; k++)
                {
                    lanes one = *(const lanes *)(from + 8 * a + k * LANES);
                    sum[k] += to[a] * one;
                    taken[k] += power[a] * one;
                }
            for (int k = 0; k < ABREAST; k++)
                *(lanes *)(now + c + k * LANES) = sum[k];
            for (size_t a = 0; a < kept; a++)
                for (int k = 0; k < ABREAST; k++)
                {
                    lanes *one = (lanes *)(from + 8 * a + k * LANES);
                    *one = fading[a] * (*one - w[a] * taken[k]);
                }
        }
        for (size_t at = (size_t)starts[i]; at < (size_t)starts[i + 1]; at++)
        {
            size_t place = (size_t)order[places[at]];
            now[place] += own[i] * numbers[at];
            double *from = before + place / 8 * 8 * terms + place % 8;
            for (size_t a = 0; a < kept; a++)
                from[8 * a] += fading[a] * w[a] * numbers[at];
        }
        if (++held == SOME || i + 1 == of.n)
        {
            add_few(held, (size_t)met, wide, starts + i + 1 - held, places, numbers, order, mixed,
                    sums);
            held = 0;
        }
    }
}

static int products(size_t n, size_t q, size_t p, size_t terms, const double *time,
                    const double *rate, const double *power, const double *variance,
                    const int64_t *starts, const int64_t *places, const double *numbers,
                    const double *full, double *room, double *d, double *normal)
{
    size_t k = q + p, wide = WIDE(p), some = WIDE(q);
    double *known = room, *decay = known + terms * terms, *weight = decay + n * terms;
    double *columns = weight + n * terms, *carried = columns + n * wide;
    double *squares = carried + terms * wide, *crossed = squares + wide * wide;
    double *sums = crossed + q * wide, *rest = sums + q * some;
    if (!factored(n, terms, time, rate, power, variance, known, decay, weight, d))
        return 0;
    struct drift of = {n, terms, power, decay, weight, d};
    for (size_t c = 0; c < wide * wide + q * (wide + some); c++)
        squares[c] = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < wide; c++)
            columns[i * wide + c] = c < p ? full[i * p + c] : 0;
    forward(of, wide, columns, carried);
    for (size_t low = 0; low < n; low += TOGETHER)
        add_squares(n - low < TOGETHER ? n - low : TOGETHER, wide, columns + low * wide, squares);
    for (size_t a = 0; a < p; a++)
        for (size_t b = 0; b <= a; b++)
            normal[(q + a) * k + q + b] = normal[(q + b) * k + q + a] = squares[a * wide + b];
    if (!q)
        return 1;
    backward(of, wide, columns, carried);
    for (size_t i = 0; i < n; i++)
        for (size_t at = (size_t)starts[i]; at < (size_t)starts[i + 1]; at++)
        {
            double by = numbers[at], *row = crossed + (size_t)places[at] * wide;
            EACH for (size_t c = 0; c < wide; c++) row[c] += by * columns[i * wide + c];
        }
    int32_t *order = (int32_t *)(rest + n * (1 + terms) + terms * (terms + 1 + some) + SOME * some);
    few_products(of, q, starts, places, numbers, order, rest, sums);
    for (size_t a = 0; a < q; a++)
    {
        for (size_t b = 0; b <= a; b++)
        {
            size_t low = (size_t)order[a], high = (size_t)order[b];
            int met = order[a] >= 0 && order[b] >= 0;
            normal[a * k + b] = normal[b * k + a] =
                met ? sums[low * some + high] + sums[high * some + low] : 0;
        }
        for (size_t b = 0; b < p; b++)
            normal[a * k + q + b] = normal[(q + b) * k + a] = crossed[a * wide + b];
    }
    return 1;
}

static void elementary(int which, size_t n, const double *y, const double *x, double *out)
{
    double sine, cosine;
    if (which == 0)
        EACH for (size_t i = 0; i < n; i++) sine_and_cosine(x[i], out + i, &cosine);
    else if (which == 1)
        EACH for (size_t i = 0; i < n; i++) sine_and_cosine(x[i], &sine, out + i);
    else if (which == 2)
        EACH for (size_t i = 0; i < n; i++) out[i] = arcsine(x[i]);
    else
        EACH for (size_t i = 0; i < n; i++) out[i] = arctangent(y[i], x[i]);
}

const struct loops LOOPS = {LEVEL, scattered, grid, look_up, gram, median, whiten, products,
                           elementary};
