/* The RT32's steering table as its program computed and printed it: the formulae are those of
   pyport.steering.as_written, rounding by rounding, and the text that of pyport.steering.ascii.
   A float is Fortran's REAL*4. The C library's functions are called one by one, as Python does. */

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "steering.h"

#define PI 3.141592653589793
#define DEGREE (PI / 180)
/* routine Hjump's */
#define SHORT_PI 3.141593f

struct mount {
    double sin_sigma, cos_sigma, sin_beta, sin_lean, cos_lean, toward, zero;
};

struct azimuth {
    double az, sin_off, cos_off;
    float az_by_sine, az_by_cosine, alt_by_sine, curve;
};

struct altitude {
    double alt, sine, cosine;
    float height;
};

static struct mount of_mount(const float *p)
{
    double sigma = p[2] * PI / 180, beta = p[3] * PI / 180;
    double sin_xi = sin(p[4] * PI / 180), sin_zeta = sin(p[5] * PI / 180);
    double lean = sqrt(sin_xi * sin_xi + sin_zeta * sin_zeta), upright = sqrt(1 - lean * lean);
    double toward = atan2(sin_zeta, sin_xi);
    return (struct mount){sin(sigma), cos(sigma), sin(beta), lean, upright, toward,
                          atan2(sin(toward), -upright * cos(toward))};
}

static struct azimuth of_azimuth(const float *p, const struct mount *m, double az_deg)
{
    double wrapped = fabs(az_deg) > 180 ? az_deg - copysign(360, az_deg) : az_deg;
    float az = (float)(wrapped * DEGREE), sine = sinf(2 * az), cosine = cosf(2 * az);
    float a = az * 180 / SHORT_PI, west = (a - 95) / 90;
    return (struct azimuth){az, sin(m->toward - az), cos(m->toward - az),
                            p[8] * sine, p[9] * cosine, p[10] * sine,
                            a <= 0 ? 65 + 7 * cosf(az / 2) : 55 + west * west * 15};
}

static struct altitude of_altitude(double zd_deg)
{
    float alt = (float)((90 - zd_deg) * DEGREE);
    return (struct altitude){alt, sin(alt), cos(alt), alt * 180 / SHORT_PI};
}

static void offsets(const float *p, const struct mount *m, const struct azimuth *a,
                    const struct altitude *h, float *d_az, float *d_alt)
{
    double sh = h->sine, ch = h->cosine, facing = fabs(ch), lean = copysign(m->sin_lean, ch);
    double turn = atan2(facing * a->sin_off, sh * lean - facing * m->cos_lean * a->cos_off)
                  - m->zero;
    turn -= a->az;
    double ht = asin(m->cos_lean * sh + lean * facing * a->cos_off);
    if (ch < 0)
        ht = ht + (2 * h->alt - PI);

    double sin_ht = sin(ht), cos_ht = cos(ht);
    double across = (m->sin_sigma * sin_ht + m->sin_beta) / (cos_ht * m->cos_sigma);
    double arc = (float)asin(fmin(1, fmax(-1, across)));
    double hb = atan2(sin_ht * m->cos_sigma + cos_ht * m->sin_sigma * sin(arc), cos_ht * cos(arc));

    *d_az = (float)(fmod((arc + turn) * 180 / PI, 360) + p[0] + a->az_by_sine + a->az_by_cosine);
    if (fabsf(*d_az) > 180)
        *d_az -= copysignf(360, *d_az);
    *d_alt = (float)((hb - h->alt) * 180 / PI + p[1] + p[6] * ch + p[7] * sh + a->alt_by_sine);
    if (h->alt < 0 ? a->curve > 0 : h->alt > 0 && a->curve <= h->height)
        *d_alt += p[11];
}

void steering_offsets(const double *p_deg, size_t n, const double *az_deg, size_t m,
                      const double *zd_deg, const double *lift_deg, int paired,
                      struct altitude *room, double *d_az_deg, double *d_zd_deg)
{
    float p[12], d_az, d_alt;
    for (int k = 0; k < 12; k++)
        p[k] = (float)p_deg[k];
    struct mount mount = of_mount(p);
    for (size_t j = 0; !paired && j < m; j++)
        room[j] = of_altitude(zd_deg[j]);
    for (size_t i = 0, at = 0; i < n; i++)
    {
        struct azimuth azimuth = of_azimuth(p, &mount, az_deg[i]);
        if (paired)
            room[0] = of_altitude(zd_deg[i]);
        for (size_t j = 0; j < (paired ? 1 : m); j++, at++)
        {
            offsets(p, &mount, &azimuth, room + j, &d_az, &d_alt);
            d_az_deg[at] = d_az;
            d_zd_deg[at] = -d_alt - (float)lift_deg[paired ? i : j];
        }
    }
}

size_t steering_room(size_t m)
{
    return (m + 1) * sizeof(struct altitude);
}

void steering_refraction(size_t n, const double *zd_deg, double *lift_deg)
{
    const float radian = 57.29f;
    for (size_t i = 0; i < n; i++)
    {
        float h = (float)((90 - fabs(zd_deg[i])) * DEGREE) * radian;
        float first = 1 / tanf((h + 7.31f / (h + 4.4f)) / radian);
        h += first / 60;
        float second = 1 / tanf((h + 7.31f / (h + 4.4f)) / radian);
        float wave = 0.06f * sinf((14.7f * first + 13) / radian);
        lift_deg[i] = (float)copysign((second - wave) / 60, zd_deg[i]);
    }
}

/* Write F`width`.7 of whole units of 1e-7; tell whether it fits. */
static int decimals(double value, size_t width, char *out)
{
    double units = rint(value * 1e7);
    if (!(fabs(units) < 2147483648.0))
        return 0;
    uint32_t rest = (uint32_t)fabs(units);
    memset(out, ' ', width);
    for (size_t place = 1; place <= 7; place++, rest /= 10)
        out[width - place] = (char)('0' + rest % 10);
    size_t place = width - 8;
    out[place] = '.';
    do
    {
        out[--place] = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest);
    if (units < 0)
        out[place - 1] = '-';
    return 1;
}

int steering_rows(size_t n, const char *az, size_t az_width, size_t m, const char *zd,
                  size_t zd_width, size_t width, const double *d_az_deg, const double *d_zd_deg,
                  char *out)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < m; j++, d_az_deg++, d_zd_deg++)
        {
            memcpy(out, az + i * az_width, az_width);
            out += az_width;
            memcpy(out, zd + j * zd_width, zd_width);
            out += zd_width;
            if (!decimals(*d_az_deg, width, out) || !decimals(*d_zd_deg, width, out + width))
                return 0;
            out += 2 * width;
            *out++ = '\n';
        }
    return 1;
}
