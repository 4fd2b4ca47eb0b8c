"""The drive program of `antenna.f`, ported statement by statement."""

import math

import numpy as np

from pyport.legacy import intrinsics

real4 = np.float32
expf = intrinsics._single("expf")
PI = 3.141592653589793
TWOPI = 6.283185307179586
MONTHS = (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)


def daynum(iy, im, id_):
    """Return the Modified Julian Day and a status."""
    if iy - 1858 < 0:
        return 0, 1
    if im < 1 or im > 12:
        return 0, 2
    days = MONTHS[im - 1]
    if im == 2:
        if iy % 4 == 0:
            days = 29
        if iy % 100 == 0 and iy % 400 != 0:
            days = 28
    status = 3 if id_ < 1 or id_ > days else 0
    jy, jm = iy, im
    if jm <= 2:
        jy, jm = jy - 1, jm + 12
    mjd = 365 * jy + jy // 4 - jy // 100 + jy // 400 + (153 * (jm - 3) + 2) // 5 + id_ - 678882
    return mjd, status


def turned(a):
    """Return an angle within pi to either side."""
    w = math.fmod(a, 2.0 * PI)
    if abs(w) >= PI:
        w = w - math.copysign(2.0 * PI, a)
    return w


def sider(mjd, ut, elong, mode):
    """Return the local mean sidereal time [rad]."""
    t = (float(mjd) - 51544.5) / 36525.0
    s = 24110.54841 + (8640184.812866 + (0.093104 - 6.2e-6 * t) * t) * t
    st = turned(s / 86400.0 * TWOPI + ut * TWOPI * 1.00273790934 + elong)
    if mode == 2:
        st = st + float(real4(1.5e-7))
    return st


def euler3(a, b, c):
    """Return the matrix of rotations about z, y and z."""
    sa, ca, sb, cb, sc, cc = (
        math.sin(a), math.cos(a), math.sin(b), math.cos(b), math.sin(c), math.cos(c)
    )  # fmt: skip
    return [
        [ca * cb * cc - sa * sc, sa * cb * cc + ca * sc, -sb * cc],
        [-ca * cb * sc - sa * cc, -sa * cb * sc + ca * cc, sb * sc],
        [ca * sb, sa * sb, cb],
    ]


def turnv(r, v):
    """Return the unit vector and the turned one."""
    s = 0.0
    for x in v.tolist():
        s = s + x * x
    s = math.sqrt(s)
    if s == 0.0:
        s = 1.0
    v = [x / s for x in v.tolist()]
    w = []
    for i in range(3):
        total = 0.0
        for j in range(3):
            total = total + float(r[i, j]) * v[j]
        w.append(total)
    return v, w


def airref(el, tc, pmb, rh, wave):
    """Return the refraction [rad]."""
    tk = tc + real4(273.15)
    pw = rh * expf(real4(17.67) * tc / (tc + real4(243.5))) * real4(6.112)
    if wave > 100:
        xn = (real4(77.6) * pmb - real4(12.8) * pw) / tk + real4(3.776e5) * pw / (tk * tk)
    else:
        xn = (real4(77.6) * pmb - real4(11.2) * pw) / tk
    z = abs(el) + 0.0031376 / (abs(el) + 0.0892) if el < 0.05 else el
    t2 = 1.0 / math.tan(z)
    return float(xn) * 1e-6 * t2 * (1.0 - float(real4(0.00117)) * t2 * t2)


def named(name):
    """Return band, frequency [MHz] and whether there is such a receiver."""
    if name in {"L     ", "LWIDE "}:
        return 1, real4(1420.4058), True
    if name[0] == "C":
        freq = real4(4829.66)
        if name[1] == "2":
            freq = freq + real4(1838.8518)
        return 2, freq, True
    if "X     " < name <= "XZ    ":
        return 3, real4(8400), True
    return 0, real4(0), False


def label(iband, north):
    """Return what the display shows."""
    digit = chr(ord("0") + abs(iband) % 10)
    return "BAND" + digit + (" N" if north else " S")


def kepler(e, ecc, anom):
    """Return what is left of Kepler's equation."""
    return e - ecc * math.sin(e) - anom


def cubic(x):
    """Return a cubic."""
    return (x * x - 2.0) * x - 5.0


def bisect(f, a, b):
    """Return a root of f between a and b, and the steps it took."""
    lo, hi = a, b
    fl = f(lo)
    for nstep in range(1, 61):
        root = 0.5 * (lo + hi)
        fm = f(root)
        if fm == 0.0 or hi - lo < 1e-12:
            return root, nstep
        if fl * fm < 0.0:
            hi = root
        else:
            lo, fl = root, fm
    return root, 60


def anomal(e1, e2, ecc, anom):
    """Return the eccentric anomaly and the steps it took."""
    if ecc < 0.0 or ecc >= 1.0:
        return anom, 0
    return bisect(lambda e: kepler(e, ecc, anom), e1, e2)


class _Saved:
    """What SMOOTH remembers."""

    sum, count = 0.0, 0


def forget():
    """Begin as the program does."""
    _Saved.sum, _Saved.count = 0.0, 0


def smooth(x):
    """Return the running mean and how many values were seen."""
    _Saved.count += 1
    w = real4(1) / real4(min(_Saved.count, 8))
    _Saved.sum = _Saved.sum + float(w) * (float(x) - _Saved.sum)
    return real4(_Saved.sum), _Saved.count


def encode(az):
    """Return the encoder's counts and whether they are at a limit."""
    x = az / (PI / 131072.0)
    count = math.floor(abs(x))
    count = int(math.copysign(count + (abs(x) - count >= 0.5), x))
    limit = count > 196608 or count < -196608
    if limit:
        count = 196608 if count > 0 else -196608
    return count, limit


def decode(count):
    """Return the azimuth of a count."""
    return count * (PI / 131072.0)


def gain(el, c):
    """Return the gain at an elevation [deg]."""
    x = (el - real4(45)) / real4(45)
    g = c[3]
    for i in (2, 1, 0):
        g = g * x + c[i]
    return real4(0) if g < 0 else g


def hadec(ha, dec, phi, height, mode):
    """Return azimuth and elevation."""
    x = -math.cos(ha) * math.cos(dec) * math.sin(phi) + math.sin(dec) * math.cos(phi)
    y = -math.sin(ha) * math.cos(dec)
    z = math.cos(ha) * math.cos(dec) * math.cos(phi) + math.sin(dec) * math.sin(phi)
    r = math.sqrt(x * x + y * y)
    az = 0.0 if r == 0.0 else math.atan2(y, x)
    if az < 0.0:
        az = az + TWOPI
    el = math.atan2(z, r)
    if mode == 1:
        el = el + float(height * real4(1e-9))
    return az, el


def sunpos(d):
    """Return right ascension and declination of the Sun."""
    rad = 1.745329251994330e-2
    g = (float(real4(357.529)) + float(real4(0.98560028)) * d) * rad
    q = float(real4(280.459)) + float(real4(0.98564736)) * d
    el = (q + float(real4(1.915)) * math.sin(g) + float(real4(0.020)) * math.sin(2 * g)) * rad
    e = (float(real4(23.439)) - float(real4(0.00000036)) * d) * rad
    ra = turned(math.atan2(math.cos(e) * math.sin(el), math.cos(el)))
    return ra, math.asin(math.sin(e) * math.sin(el))


def wrapit(now, want):
    """Return the azimuth that is driven to, its turn, and the way there."""
    best, nturn = 1e10, 0
    for i in (1, 2, 3):
        a = want + (i - 2) * TWOPI
        d = abs(a - now)
        if abs(a) <= 1.5 * TWOPI and d < best:
            best, nturn = d, i - 2
    # the middle one of the three, which ABEST is equivalent to, is WANT itself
    driven = (want + 0 * TWOPI) + nturn * TWOPI
    return driven, nturn, driven - now


def clip(x, xlim, mode):
    """Return a value kept within limits."""
    y = max(xlim[0], min(xlim[1], x))
    if mode == 3:
        y = np.copysign(xlim[1], x)
    if y == x:
        return y
    return x if abs(y - x) <= real4(1e-6) else y


def nbeam(freq, dist):
    """Return how many beams apart two directions are."""
    return int(dist / (1.22 * 299.792458 / (float(freq) * 32.0)))


def pathl(el, h):
    """Return the excess path [m]."""
    d = 2.2768 * math.exp(-h / 8434.5)
    return d / math.sin(el) if el >= 0.1 else d / (math.sin(el) + 0.015)


def safe(wind, naz, stowed):
    """Return whether the wind lets the antenna move."""
    w = real4(0)
    for x in wind:
        w = w + x * x
    w = np.sqrt(w)
    if naz > 2 and w > 15:
        return False
    return bool(w < 20 and not stowed)
