"""SLALIB's routines as pyerfa answers them, argument for argument; dates are MJD."""

import erfa
import numpy as np

MJD0 = 2400000.5
#: The spheroid and astronomical unit that SLALIB has [m].
IAU1976_M, FLATTENING, AU_M = 6378140.0, 1 / 298.257, 1.49597870e11

dcs2c = erfa.s2c
dcc2s = erfa.c2s
dranrm = erfa.anp
drange = erfa.anpm
dsep = erfa.seps
dbear = erfa.pas
dmxv = erfa.rxp
dimxv = erfa.trxp
dmxm = erfa.rxr
dvdv = erfa.pdp
dvxv = erfa.pxp
dav2m = erfa.rv2m
de2h = erfa.hd2ae
dh2e = erfa.ae2hd
pa = erfa.hd2pa
eqgal = erfa.icrs2g
galeq = erfa.g2icrs
dtp2s = erfa.tpsts
ds2tp = erfa.ufunc.tpxes


def dvn(v):
    modulus, unit = erfa.pn(v)
    return unit, modulus


def epj(date):
    return erfa.epj(MJD0, date)


def epj2d(epoch):
    return erfa.epj2jd(epoch)[1]


def epb(date):
    return erfa.epb(MJD0, date)


def epb2d(epoch):
    return erfa.epb2jd(epoch)[1]


def gmst(ut1):
    return erfa.gmst82(MJD0, ut1)


def eqeqx(date):
    return erfa.eqeq94(MJD0, date)


def prec(ep1):
    return erfa.pmat76(*erfa.epj2jd(ep1))


def nutc80(date):
    dpsi, deps = erfa.nut80(MJD0, date)
    return dpsi, deps, erfa.obl80(MJD0, date)


def nutc(date):
    dpsi, deps = erfa.nut00a(MJD0, date)
    precession, obliquity = erfa.pr00(MJD0, date)
    return dpsi + precession, deps + obliquity, erfa.obl80(MJD0, date)


def ecmat(date):
    return erfa.rx(erfa.obl80(MJD0, date), np.broadcast_to(np.eye(3), (len(date), 3, 3)).copy())


def fk5hz(r5, d5, epoch):
    return erfa.fk5hz(r5, d5, *erfa.epj2jd(epoch))


def geoc(p, h):
    x, _, z = erfa.gd2gce(IAU1976_M, FLATTENING, np.zeros_like(p), p, h).T
    return x / AU_M, z / AU_M


def pvobs(p, h, stl):
    pv = erfa.pvtob(np.zeros_like(p), p, h, 0.0, 0.0, 0.0, stl)
    return np.concatenate([pv["p"], pv["v"]], axis=1) / AU_M


def epv(date):
    heliocentric, barycentric = erfa.epv00(MJD0, date)
    return heliocentric["p"], heliocentric["v"], barycentric["p"], barycentric["v"]


def rcc(tdb, ut1, wl, u, v):
    return erfa.dtdb(MJD0, tdb, ut1, -wl, u, v)  # SLALIB counts longitude westward


def cldj(iy, im, id_):
    _, day, status = erfa.ufunc.cal2jd(iy, im, id_)
    return day, -status


def djcl(djm):
    year, month, day, fraction, status = erfa.ufunc.jd2cal(MJD0, djm)
    return year, month, day, fraction, status


def dat(utc):
    year, month, day, fraction = erfa.jd2cal(MJD0, utc)
    return erfa.dat(year, month, day, fraction)


def refcoq(tdk, pmb, rh, wl):
    return erfa.refco(pmb, tdk - 273.15, rh, wl)


def refz(zu, refa, refb):
    """Solve what the constants mean, ZU = ZR + A tan ZR + B tan**3 ZR, for ZR."""
    zr = zu.copy()
    for _ in range(60):
        t = np.tan(zr)
        zr = zu - (refa + refb * t * t) * t
    return zr
