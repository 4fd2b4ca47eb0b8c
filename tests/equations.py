"""The equations of the RT32's model in 50 digits: what the routines would answer without rounding.

Equations 1, 2, 15, 16, 18 and 19 of RT32 Pointing Model (2004) and the text around Hjump, with a pi
that has all its digits. Arguments as for the routines: azimuth from south through west and altitude
[rad], parameters and answers [deg].

In plunge the routines turn the tilt's sign, and Model the change of azimuth with it. The equations
do not, when they are continued beyond 90 deg; `turned` says which is wanted.
"""

from mpmath import mp, mpf

mp.dps = 50


def _deg(x):
    return x * 180 / mp.pi


def _rad(x):
    return mpf(float(x)) * mp.pi / 180


def _half_turn(x):
    """Bring an angle [deg] into -180 to 180."""
    return x - 360 * mp.nint(x / 360)


def hjump(az, alt):
    """Return 0 or 1, and below the horizon the altitude of the curve [deg]."""
    az, alt = mpf(float(az)), mpf(float(alt))
    curve = 65 + 7 * mp.cos(az / 2) if az <= 0 else 55 + ((_deg(az) - 95) / 90) ** 2 * 15
    if alt < 0:
        return curve
    return mpf(int(alt > 0 and curve <= _deg(alt)))


def _step(az, alt, p):
    """Return p12 above the curve; below the horizon there is no jump."""
    return mpf(float(p[11])) * (hjump(az, alt) if alt > 0 else 0)


def model(az, alt, p, *, turned=True):
    """Return the exact form's offsets; NaN where no setting of the axes reaches the source."""
    p_deg = [mpf(float(value)) for value in p]
    sigma, beta, xi, zeta = (_rad(value) for value in p[2:6])
    a, h = mpf(float(az)), mpf(float(alt))
    plunge = mp.cos(h) < 0
    eta = mp.asin(mp.hypot(mp.sin(xi), mp.sin(zeta))) * (-1 if plunge and turned else 1)
    alpha = mp.atan2(mp.sin(zeta), mp.sin(xi))
    seen = mp.atan2(
        mp.cos(h) * mp.sin(alpha - a),
        mp.sin(h) * mp.sin(eta) - mp.cos(h) * mp.cos(eta) * mp.cos(alpha - a),
    ) - mp.atan2(mp.sin(alpha), -mp.cos(eta) * mp.cos(alpha))
    h1 = mp.asin(mp.sin(h) * mp.cos(eta) + mp.cos(h) * mp.sin(eta) * mp.cos(alpha - a))
    change = seen - a
    if plunge:
        change, h1 = mp.pi + (-change if turned else change), mp.pi - h1
    sine = (mp.sin(h1) * mp.sin(sigma) + mp.sin(beta)) / (mp.cos(h1) * mp.cos(sigma))
    if abs(sine) > 1:
        return mp.nan, mp.nan
    arc = mp.asin(sine)
    h2 = mp.atan2(
        mp.sin(h1) * mp.cos(sigma) + mp.cos(h1) * mp.sin(sigma) * mp.sin(arc),
        mp.cos(h1) * mp.cos(arc),
    )
    daz = _deg(change + arc) + p_deg[0] + p_deg[8] * mp.sin(2 * a) + p_deg[9] * mp.cos(2 * a)
    dalt = _deg(h2 - h) + p_deg[1] + p_deg[6] * mp.cos(h) + p_deg[7] * mp.sin(h)
    return _half_turn(daz), dalt + p_deg[10] * mp.sin(2 * a) + _step(az, alt, p)


def modela(az, alt, p, *, turned=True):
    """Return the approximate form's offsets."""
    q = [mpf(float(value)) for value in p]
    a, h = mpf(float(az)), mpf(float(alt))
    daz = (
        q[0]
        + (q[2] + q[4] * mp.sin(a) - q[5] * mp.cos(a)) * mp.tan(h)
        + q[3] / mp.cos(h)
        + q[8] * mp.sin(2 * a)
        + q[9] * mp.cos(2 * a)
    )
    side = -1 if h > mp.pi / 2 and turned else 1
    dalt = (
        q[1]
        + side * (q[4] * mp.cos(a) + q[5] * mp.sin(a))
        + q[6] * mp.cos(h)
        + q[7] * mp.sin(h)
        + q[10] * mp.sin(2 * a)
    )
    return _half_turn(daz), dalt + _step(az, alt, p)


def answers(az, alt, p, *, turned=True):
    """Return the five answers in the order of the routines' outputs."""
    return [
        *model(az, alt, p, turned=turned),
        *modela(az, alt, p, turned=turned),
        hjump(az, alt),
    ]
