C     A drive program as they were written in the seventies, made up for
C     tests: every way of passing a value that FORTRAN 77 has.
C
      SUBROUTINE DAYNUM(IY, IM, ID, MJD, ISTAT)
C     Modified Julian Day of a date of the Gregorian calendar.
C     ISTAT: 0 good, 1 year before 1858, 2 bad month, 3 bad day.
      INTEGER IY, IM, ID, MJD, ISTAT
      INTEGER LEN(12), JY, JM, NDAYS
      DATA LEN /31,28,31,30,31,30,31,31,30,31,30,31/
      MJD = 0
      ISTAT = 0
      IF (IY - 1858) 10, 20, 20
   10 ISTAT = 1
      RETURN
   20 IF (IM .LT. 1 .OR. IM .GT. 12) THEN
         ISTAT = 2
         RETURN
      END IF
      NDAYS = LEN(IM)
      IF (IM .EQ. 2) THEN
         IF (MOD(IY,4) .EQ. 0) NDAYS = 29
         IF (MOD(IY,100) .EQ. 0 .AND. MOD(IY,400) .NE. 0) NDAYS = 28
      END IF
      IF (ID .LT. 1 .OR. ID .GT. NDAYS) ISTAT = 3
      JY = IY
      JM = IM
      IF (JM .LE. 2) THEN
         JY = JY - 1
         JM = JM + 12
      END IF
      MJD = 365*JY + JY/4 - JY/100 + JY/400 + (153*(JM-3)+2)/5
     *      + ID - 678882
      END
C
      DOUBLE PRECISION FUNCTION TURNED(A)
C     An angle taken into +-pi.
      DOUBLE PRECISION A, PI, W
      PARAMETER (PI = 3.141592653589793238D0)
      W = DMOD(A, 2D0*PI)
      IF (DABS(W) .GE. PI) W = W - DSIGN(2D0*PI, A)
      TURNED = W
      END
C
      SUBROUTINE SIDER(MJD, UT, ST)
C     Local mean sidereal time [rad] of a day and a fraction of it.
      INTEGER MJD
      DOUBLE PRECISION UT, ST, T, S, TURNED, TWOPI
      INCLUDE 'site.inc'
      DATA TWOPI /6.283185307179586D0/
      T = (DBLE(MJD) - 51544.5D0)/36525D0
      S = 24110.54841D0 + (8640184.812866D0
     *    + (0.093104D0 - 6.2D-6*T)*T)*T
      ST = TURNED(S/86400D0*TWOPI + UT*TWOPI*1.00273790934D0 + ELONG)
      IF (MODE .EQ. 2) ST = ST + 1.5E-7
      END
C
      SUBROUTINE EULER3(A, B, C, R)
C     The matrix of three rotations about z, y and z.
      DOUBLE PRECISION A, B, C, R(3,3)
      DOUBLE PRECISION SA, CA, SB, CB, SC, CC
      SA = DSIN(A)
      CA = DCOS(A)
      SB = DSIN(B)
      CB = DCOS(B)
      SC = DSIN(C)
      CC = DCOS(C)
      R(1,1) = CA*CB*CC - SA*SC
      R(1,2) = SA*CB*CC + CA*SC
      R(1,3) = -SB*CC
      R(2,1) = -CA*CB*SC - SA*CC
      R(2,2) = -SA*CB*SC + CA*CC
      R(2,3) = SB*SC
      R(3,1) = CA*SB
      R(3,2) = SA*SB
      R(3,3) = CB
      END
C
      SUBROUTINE TURNV(R, V, N, W)
C     W is R times V; V is made a unit vector on the way.
      INTEGER N, I, J
      DOUBLE PRECISION R(3,3), V(N), W(N), S
      S = 0D0
      DO 10 I = 1, N
         S = S + V(I)*V(I)
   10 CONTINUE
      S = DSQRT(S)
      IF (S .EQ. 0D0) S = 1D0
      DO 20 I = 1, N
         V(I) = V(I)/S
   20 CONTINUE
      DO 40 I = 1, N
         W(I) = 0D0
         DO 30 J = 1, N
            W(I) = W(I) + R(I,J)*V(J)
   30    CONTINUE
   40 CONTINUE
      END
C
      SUBROUTINE AIRREF(EL, TC, PMB, RH, WAVE, DEL)
C     Refraction [rad] at an elevation [rad]; weather in REAL*4. Above
C     100 microns it is that of radio waves.
      DOUBLE PRECISION EL, DEL, Z, T2
      REAL TC, PMB, RH, WAVE, TK, PW, XN
      TK = TC + 273.15
      PW = RH*EXP(17.67*TC/(TC + 243.5))*6.112
      IF (WAVE .GT. 100.) THEN
         XN = (77.6*PMB - 12.8*PW)/TK + 3.776E5*PW/TK**2
      ELSE
         XN = (77.6*PMB - 11.2*PW)/TK
      END IF
      IF (EL .LT. 0.05D0) THEN
         Z = DABS(EL) + 0.0031376D0/(DABS(EL) + 0.0892D0)
      ELSE
         Z = EL
      END IF
      T2 = 1D0/DTAN(Z)
      DEL = XN*1D-6*T2*(1D0 - 0.00117*T2*T2)
      END
C
      SUBROUTINE NAMED(NAME, IBAND, FREQ, OK)
C     The receiver of a name: its band, frequency [MHz], and whether
C     there is one.
      CHARACTER*6 NAME
      INTEGER IBAND
      REAL FREQ
      LOGICAL OK
      OK = .TRUE.
      IF (NAME .EQ. 'L' .OR. NAME .EQ. 'LWIDE') THEN
         IBAND = 1
      ELSE IF (NAME(1:1) .EQ. 'C') THEN
         IBAND = 2
      ELSE IF (NAME .GT. 'X' .AND. NAME .LE. 'XZ') THEN
         IBAND = 3
      ELSE
         IBAND = 0
         OK = .FALSE.
      END IF
      GO TO (10, 20, 30), IBAND
      FREQ = 0.
      RETURN
   10 FREQ = 1420.4058
      RETURN
   20 FREQ = 4829.66
      IF (NAME(2:2) .EQ. '2') FREQ = FREQ + 1838.8518
      RETURN
   30 FREQ = 8400.
      END
C
      CHARACTER*8 FUNCTION LABEL(IBAND, NORTH)
C     What the display shows.
      INTEGER IBAND
      LOGICAL NORTH
      CHARACTER*1 DIGIT
      DIGIT = CHAR(ICHAR('0') + IABS(MOD(IBAND, 10)))
      IF (NORTH) THEN
         LABEL = 'BAND'//DIGIT//' N'
      ELSE
         LABEL = 'BAND'//DIGIT//' S'
      END IF
      END
C
      DOUBLE PRECISION FUNCTION KEPLER(E)
C     What is left of Kepler's equation; orbit in blank COMMON.
      DOUBLE PRECISION E, ECC, ANOM
      COMMON ECC, ANOM
      KEPLER = E - ECC*DSIN(E) - ANOM
      END
C
      DOUBLE PRECISION FUNCTION CUBIC(X)
C     Another function to look for a root of.
      DOUBLE PRECISION X
      CUBIC = (X*X - 2D0)*X - 5D0
      END
C
      SUBROUTINE BISECT(F, A, B, ROOT, NSTEP)
C     A root of F between A and B.
      DOUBLE PRECISION F, A, B, ROOT, LO, HI, FM, FL
      INTEGER NSTEP
      EXTERNAL F
      LO = A
      HI = B
      FL = F(LO)
      DO 10 NSTEP = 1, 60
         ROOT = 0.5D0*(LO + HI)
         FM = F(ROOT)
         IF (FM .EQ. 0D0 .OR. HI - LO .LT. 1D-12) RETURN
         IF (FL*FM .LT. 0D0) THEN
            HI = ROOT
         ELSE
            LO = ROOT
            FL = FM
         END IF
   10 CONTINUE
      NSTEP = 60
      END
C
      SUBROUTINE ANOMAL(E1, E2, ROOT, NSTEP)
C     Kepler's equation, solved.
      DOUBLE PRECISION E1, E2, ROOT, ECC, ANOM, KEPLER
      INTEGER NSTEP
      COMMON ECC, ANOM
      EXTERNAL KEPLER
      IF (ECC .LT. 0D0 .OR. ECC .GE. 1D0) THEN
         ROOT = ANOM
         NSTEP = 0
         RETURN
      END IF
      CALL BISECT(KEPLER, E1, E2, ROOT, NSTEP)
      END
C
      SUBROUTINE SMOOTH(X, Y, NSEEN)
C     The running mean of what was seen; it forgets with a time constant
C     of eight values. SMRSET begins anew.
      REAL X, Y, W
      DOUBLE PRECISION SUM
      INTEGER NSEEN, KOUNT
      SAVE SUM, KOUNT
      DATA SUM /0D0/, KOUNT /0/
      KOUNT = KOUNT + 1
      W = 1./MIN(KOUNT, 8)
      SUM = SUM + W*(X - SUM)
      Y = SUM
      NSEEN = KOUNT
      RETURN
      ENTRY SMRSET(NSEEN)
      NSEEN = KOUNT
      SUM = 0D0
      KOUNT = 0
      END
C
      SUBROUTINE ENCODE(AZ, ICOUNT, LIMIT)
C     Azimuth [rad] as counts of an encoder of 18 bits, and back.
      DOUBLE PRECISION AZ, STEP
      INTEGER ICOUNT
      LOGICAL LIMIT
      PARAMETER (STEP = 3.141592653589793238D0/131072D0)
      ICOUNT = NINT(AZ/STEP)
      LIMIT = ICOUNT .GT. 196608 .OR. ICOUNT .LT. -196608
      IF (LIMIT) ICOUNT = ISIGN(196608, ICOUNT)
      RETURN
      ENTRY DECODE(ICOUNT, AZ)
      AZ = ICOUNT*STEP
      END
C
      REAL FUNCTION GAIN(EL, C)
C     Gain at an elevation [deg], a polynomial in REAL*4.
      REAL EL, C(4), X
      INTEGER I
      X = (EL - 45.)/45.
      GAIN = C(4)
      DO 10 I = 3, 1, -1
         GAIN = GAIN*X + C(I)
   10 CONTINUE
      IF (GAIN .LT. 0.) GAIN = 0.
      END
C
      SUBROUTINE HADEC(HA, DEC, AZ, EL)
C     Azimuth from north through east, elevation; latitude in COMMON.
      DOUBLE PRECISION HA, DEC, AZ, EL, X, Y, Z, R
      INCLUDE 'site.inc'
      X = -DCOS(HA)*DCOS(DEC)*DSIN(PHI) + DSIN(DEC)*DCOS(PHI)
      Y = -DSIN(HA)*DCOS(DEC)
      Z = DCOS(HA)*DCOS(DEC)*DCOS(PHI) + DSIN(DEC)*DSIN(PHI)
      R = DSQRT(X*X + Y*Y)
      IF (R .EQ. 0D0) THEN
         AZ = 0D0
      ELSE
         AZ = DATAN2(Y, X)
      END IF
      IF (AZ .LT. 0D0) AZ = AZ + 6.283185307179586D0
      EL = DATAN2(Z, R)
      IF (MODE .EQ. 1) EL = EL + HEIGHT*1E-9
      END
C
      SUBROUTINE SUNPOS(D, RA, DEC)
C     The Sun, low precision; constants in single precision, as typed.
      DOUBLE PRECISION D, RA, DEC, G, Q, L, E, TURNED
      DOUBLE PRECISION RAD
      DATA RAD /1.745329251994330D-2/
      G = (357.529 + 0.98560028*D)*RAD
      Q = 280.459 + 0.98564736*D
      L = (Q + 1.915*DSIN(G) + 0.020*DSIN(2*G))*RAD
      E = (23.439 - 0.00000036*D)*RAD
      RA = TURNED(DATAN2(DCOS(E)*DSIN(L), DCOS(L)))
      DEC = DASIN(DSIN(E)*DSIN(L))
      END
C
      SUBROUTINE WRAPIT(NOW, WANT, NTURN, PATH)
C     The way to go from NOW to WANT [rad] with a cable of +-1.5 turns;
C     WANT is changed to the azimuth that is driven to.
      DOUBLE PRECISION NOW, WANT, PATH, TWOPI, A(3), D(3), BEST
      DOUBLE PRECISION ABEST
      INTEGER NTURN, I
      EQUIVALENCE (A(2), ABEST)
      PARAMETER (TWOPI = 6.283185307179586D0)
      BEST = 1D10
      NTURN = 0
      DO 10 I = 1, 3
         A(I) = WANT + (I - 2)*TWOPI
         D(I) = DABS(A(I) - NOW)
         IF (DABS(A(I)) .LE. 1.5D0*TWOPI .AND. D(I) .LT. BEST) THEN
            BEST = D(I)
            NTURN = I - 2
         END IF
   10 CONTINUE
      WANT = ABEST + NTURN*TWOPI
      PATH = WANT - NOW
      END
C
      SUBROUTINE CLIP(X, XLIM, Y)
C     A value kept within limits that depend on the mode.
      REAL X, XLIM(2), Y
      INCLUDE 'site.inc'
      Y = AMAX1(XLIM(1), AMIN1(XLIM(2), X))
      IF (MODE .EQ. 3) Y = SIGN(XLIM(2), X)
      IF (Y .EQ. X) RETURN
      IF (ABS(Y - X) .LE. 1.E-6) Y = X
      END
C
      INTEGER FUNCTION NBEAM(FREQ, DIST)
C     How many beams apart two directions are; statement function.
      REAL FREQ
      DOUBLE PRECISION DIST, BEAM, F
      BEAM(F) = 1.22D0*299.792458D0/(F*32D0)
      NBEAM = INT(DIST/BEAM(DBLE(FREQ)))
      END
C
      LOGICAL FUNCTION SAFE(WIND, NAZ, STOWED)
C     Whether the wind [m/s] lets the antenna move.
      REAL WIND(3), W
      INTEGER NAZ, I
      LOGICAL STOWED
      W = 0.
      DO 10 I = 1, 3
         W = W + WIND(I)**2
   10 CONTINUE
      W = SQRT(W)
      SAFE = W .LT. 20. .AND. .NOT. STOWED
      IF (NAZ .GT. 2 .AND. W .GT. 15.) SAFE = .FALSE.
      END
C
      SUBROUTINE PATHL(EL, H, D)
C     Excess path [m] of the dry air at an elevation [rad], from height H.
      DOUBLE PRECISION EL, H, D
      IF (EL .GE. 0.1D0) THEN
         D = 2.2768D0*DEXP(-H/8434.5D0)/DSIN(EL)
      ELSE
         D = 2.2768D0*DEXP(-H/8434.5D0)/(DSIN(EL) + 0.015D0)
      END IF
      END
C
      SUBROUTINE COMPLX(Z, X)
C     Is refused: its argument is COMPLEX.
      COMPLEX Z
      REAL X
      X = REAL(Z)
      END
C
      SUBROUTINE ESCAPE(X, Y, *)
C     Is refused: it may return elsewhere.
      REAL X, Y
      Y = X
      IF (X .LT. 0.) RETURN 1
      END
C
      SUBROUTINE HALTS(X, Y)
C     Ends the program at a negative number.
      REAL X, Y
      IF (X .LT. 0.) STOP 'NEGATIVE'
      Y = SQRT(X)
      END
C
      BLOCK DATA START
      INCLUDE 'site.inc'
      DATA ELONG /0.3D0/, PHI /0.9D0/, HEIGHT /100./, MODE /0/
      END
