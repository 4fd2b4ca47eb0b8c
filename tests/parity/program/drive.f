C     The other half of the drive program: what follows the antenna from
C     one interrupt to the next. Names that are not declared have the
C     types that FORTRAN gives them, or that IMPLICIT does.
C
      SUBROUTINE SERVO(WANT, DT, RATE, IOVER)
C     One step of the position loop of both axes: rates [deg/s] for the
C     wanted position [deg]. The loop's state is in COMMON, and changed.
      REAL WANT(2), RATE(2), DT, ERR
      REAL POS(2), SUM(2), RMAX
      INTEGER*2 IOVER
      LOGICAL HELD
      COMMON /LOOP/ POS, SUM, RMAX, HELD
      IOVER = 0
      DO 30 I = 1, 2
         ERR = WANT(I) - POS(I)
         IF (HELD) ERR = 0.
         SUM(I) = SUM(I) + ERR*DT
         RATE(I) = 2.5*ERR + 0.3*SUM(I)
         IF (ABS(RATE(I)) - RMAX) 20, 20, 10
   10    RATE(I) = SIGN(RMAX, RATE(I))
         SUM(I) = SUM(I) - ERR*DT
         IOVER = IOVER + 2**(I - 1)
   20    POS(I) = POS(I) + RATE(I)*DT
   30 CONTINUE
      END
C
      SUBROUTINE TERMS(AZ, EL, C, DAZ, DEL)
C     The classical seven terms [deg]; the tilt in whole arcseconds, as
C     the level shows it.
      IMPLICIT REAL*8 (A-H, O-Z)
      DIMENSION C(-3:3)
      LEAN(X, Y) = NINT(3.6D3*(X*DSIN(AZ) - Y*DCOS(AZ)))
      TILT = LEAN(C(-1), C(1))/3.6D3
      DAZ = C(0) + C(-3)/DCOS(EL) + (C(-2) + TILT)*DTAN(EL)
      DEL = C(2) + C(1)*DSIN(AZ) + C(-1)*DCOS(AZ) + C(3)*DCOS(EL)
      END
C
      SUBROUTINE SWING(T, Y, DY)
C     What a step of the drive leaves: a damped oscillation. It is
C     passed to RUNGE.
      DOUBLE PRECISION T, Y(2), DY(2)
      DY(1) = Y(2)
      DY(2) = -4D0*Y(1) - 0.3*Y(2) + DSIN(T)
      END
C
      SUBROUTINE RUNGE(DERIV, T, Y, N, H)
C     One step of fourth order of N differential equations; DERIV is a
C     subroutine.
      DOUBLE PRECISION T, H, Y(N), A(4), B(4), Z(4), S(4)
      EXTERNAL DERIV
      CALL DERIV(T, Y, A)
      DO 10 I = 1, N
         S(I) = A(I)
   10    Z(I) = Y(I) + 0.5D0*H*A(I)
      DO 40 K = 1, 2
         CALL DERIV(T + 0.5D0*H, Z, B)
         DO 30 I = 1, N
            S(I) = S(I) + 2D0*B(I)
            IF (K .EQ. 1) Z(I) = Y(I) + 0.5D0*H*B(I)
            IF (K .EQ. 2) Z(I) = Y(I) + H*B(I)
   30    CONTINUE
   40 CONTINUE
      T = T + H
      CALL DERIV(T, Z, B)
      DO 50 I = 1, N
   50    Y(I) = Y(I) + H*(S(I) + B(I))/6D0
      END
C
      SUBROUTINE SOLVE(A, LDA, B, N, ISING)
C     Linear equations, by elimination with pivots, in place. ISING is
C     the column in which no pivot was found.
      DOUBLE PRECISION A(LDA,*), B(*), BIG, F, S
      ISING = 0
      DO 60 K = 1, N
         M = K
         BIG = DABS(A(K,K))
         DO 10 I = K + 1, N
            IF (DABS(A(I,K)) .LE. BIG) GO TO 10
            M = I
            BIG = DABS(A(I,K))
   10    CONTINUE
         IF (BIG .LT. 1E-9) THEN
            ISING = K
            RETURN
         END IF
         IF (M .EQ. K) GO TO 30
         DO 20 J = K, N
            S = A(K,J)
            A(K,J) = A(M,J)
   20       A(M,J) = S
         S = B(K)
         B(K) = B(M)
         B(M) = S
   30    DO 50 I = K + 1, N
            F = A(I,K)/A(K,K)
            DO 40 J = K, N
   40          A(I,J) = A(I,J) - F*A(K,J)
   50       B(I) = B(I) - F*B(K)
   60 CONTINUE
      DO 80 K = N, 1, -1
         S = B(K)
         DO 70 J = K + 1, N
   70       S = S - A(K,J)*B(J)
   80    B(K) = S/A(K,K)
      END
C
      SUBROUTINE MEDIAN(X, Y, FULL)
C     The median of the last five values; MEDSET fills the memory with
C     one value.
      REAL X, Y, Z(5), KEPT(5)
      LOGICAL*1 FULL
      SAVE KEPT, NEXT, NSEEN
      DATA KEPT /5*0./, NEXT /1/, NSEEN /0/
      KEPT(NEXT) = X
      NEXT = MOD(NEXT, 5) + 1
      NSEEN = NSEEN + 1
      FULL = NSEEN .GE. 5
      DO 20 I = 1, 5
         J = I
   10    IF (J .EQ. 1) GO TO 20
         IF (Z(J-1) .LE. KEPT(I)) GO TO 20
         Z(J) = Z(J-1)
         J = J - 1
         GO TO 10
   20    Z(J) = KEPT(I)
      Y = Z(3)
      RETURN
      ENTRY MEDSET(X, Y)
      DO 30 I = 1, 5
   30    KEPT(I) = X
      NSEEN = 5
      Y = KEPT(NEXT)
      END
C
      INTEGER FUNCTION NSECS(TEXT, SIGN)
C     Arcseconds of an angle as an operator types it: -12:34:56; 9999999
C     where it is none. Whatever stands behind a blank is a remark.
      CHARACTER*(*) TEXT
      CHARACTER*1 C
      INTEGER*2 SIGN
      SIGN = 1
      NSECS = 0
      NPART = 0
      K = 1
      IF (INDEX('+-', TEXT(1:1)) .GT. 0) K = 2
      IF (TEXT(1:1) .EQ. '-') SIGN = -1
      DO 20 I = K, LEN(TEXT)
         C = TEXT(I:I)
         IF (C .EQ. ' ') GO TO 30
         IF (C .EQ. ':') THEN
            NSECS = NSECS + NPART
            NSECS = NSECS*60
            NPART = 0
            GO TO 20
         END IF
         IF (LLT(C, '0') .OR. LGT(C, '9')) GO TO 40
         NPART = 10*NPART + ICHAR(C) - ICHAR('0')
   20 CONTINUE
   30 NSECS = (NSECS + NPART)*SIGN
      RETURN
   40 NSECS = 9999999
      END
C
      CHARACTER*9 FUNCTION SHOWN(RAD)
C     Degrees and minutes on the display: an internal WRITE.
      DOUBLE PRECISION RAD
      MINS = NINT(DABS(RAD)*3437.74677D0)
      WRITE (SHOWN, 100) MINS/60, MOD(MINS, 60)
  100 FORMAT (1X, I4.3, ' ', I2.2, '''')
      IF (RAD .LT. 0D0) SHOWN(1:1) = '-'
      END
