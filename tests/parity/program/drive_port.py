"""The other half of the drive program, `drive.f`, ported statement by statement."""

import math

import numpy as np

real4 = np.float32


def nint(x):
    """Return the nearest integer, halves away from zero."""
    whole = math.floor(abs(x))
    return int(math.copysign(whole + (abs(x) - whole >= 0.5), x))


def servo(want, dt, pos, total, rmax, held):
    """Return rates, what is over its limit, and the loop's new state."""
    rate, over = [], 0
    for i in (0, 1):
        err = real4(0) if held else want[i] - pos[i]
        total[i] = total[i] + err * dt
        r = real4(2.5) * err + real4(0.3) * total[i]
        if abs(r) - rmax > 0:
            r = np.copysign(rmax, r)
            total[i] = total[i] - err * dt
            over += 2**i
        pos[i] = pos[i] + r * dt
        rate.append(r)
    return rate, over, pos, total


def terms(az, el, c):
    """Return the offsets of the seven terms."""
    flex_az, box, west, zero, north, zero_el, sag = c.tolist()
    tilt = nint(3.6e3 * (west * math.sin(az) - north * math.cos(az))) / 3.6e3
    daz = zero + flex_az / math.cos(el) + (box + tilt) * math.tan(el)
    return daz, zero_el + north * math.sin(az) + west * math.cos(az) + sag * math.cos(el)


def swing(t, y):
    """Return the derivatives of a damped oscillation."""
    return [y[1], -4.0 * y[0] - float(real4(0.3)) * y[1] + math.sin(t)]


def runge(deriv, t, y, h):
    """Return time and state after one step."""
    y = y.tolist()
    a = deriv(t, y)
    s = list(a)
    z = [y[i] + 0.5 * h * a[i] for i in (0, 1)]
    for k in (1, 2):
        b = deriv(t + 0.5 * h, z)
        s = [s[i] + 2.0 * b[i] for i in (0, 1)]
        z = [y[i] + 0.5 * h * b[i] if k == 1 else y[i] + h * b[i] for i in (0, 1)]
    t = t + h
    b = deriv(t, z)
    return t, [y[i] + h * (s[i] + b[i]) / 6.0 for i in (0, 1)]


def solve(a, b):
    """Return the matrix and vector after the elimination, and the column without a pivot."""
    a, b = a.tolist(), b.tolist()
    n = len(b)
    for k in range(n):
        m = max(range(k, n), key=lambda i: (abs(a[i][k]), -i))
        if abs(a[m][k]) < float(real4(1e-9)):
            return a, b, k + 1
        for j in range(k, n):
            a[k][j], a[m][j] = a[m][j], a[k][j]
        b[k], b[m] = b[m], b[k]
        for i in range(k + 1, n):
            f = a[i][k] / a[k][k]
            for j in range(k, n):
                a[i][j] = a[i][j] - f * a[k][j]
            b[i] = b[i] - f * b[k]
    for k in range(n - 1, -1, -1):
        s = b[k]
        for j in range(k + 1, n):
            s = s - a[k][j] * b[j]
        b[k] = s / a[k][k]
    return a, b, 0


class _Saved:
    """What MEDIAN remembers."""

    values, place, seen = [real4(0)] * 5, 0, 0


def forget():
    """Begin as the program does."""
    _Saved.values, _Saved.place, _Saved.seen = [real4(0)] * 5, 0, 0


def median(x):
    """Return the median of the last five values, and whether there were five."""
    _Saved.values[_Saved.place] = x
    _Saved.place = (_Saved.place + 1) % 5
    _Saved.seen += 1
    return sorted(_Saved.values)[2], _Saved.seen >= 5


def medset(x):
    """Return the value that the memory is filled with."""
    _Saved.values, _Saved.seen = [x] * 5, 5
    return _Saved.values[_Saved.place]


def nsecs(text):
    """Return the arcseconds of an angle and its sign."""
    sign = -1 if text[0] == "-" else 1
    total = part = 0
    for c in text[text[0] in "+-" :]:
        if c == " ":
            break
        if c == ":":
            total, part = (total + part) * 60, 0
        elif "0" <= c <= "9":
            part = 10 * part + ord(c) - ord("0")
        else:
            return 9999999, sign
    return (total + part) * sign, sign


def shown(rad):
    """Return degrees and minutes as the display has them."""
    degrees, minutes = divmod(nint(abs(rad) * 3437.74677), 60)
    return f"{'-' if rad < 0 else ' '}{f'{degrees:03}':>4} {minutes:02}'"
