	subroutine ModelA(Az,Alt,dAz,dAlt,p)
c RT32 model for azimuth and altitude offsets; parameters p are
c in degrees. Should be good for Alt > pi/2 since then p5 and
c p6 both get opposite signs relative to pi - Alt direction and
c assuming p9 and p10 are connected with wheels position on
c the azimuth track.
	real*4 p(12)
	data pi/3.141593/
c ********* Model for azimuth offset **********
	t=tan(Alt)
	dAz=p(1)	! encoder offset
     *+p(3)*t		! axis skew
     *+p(4)/cos(Alt)	! box offset
     *+p(5)*sin(Az)*t	! tilt out  (toward Az=0 deg)
     *-p(6)*cos(Az)*t	! tilt over (toward Az=90 deg)
     *+p(9)*sin(2*Az)	! ad hoc
     *+p(10)*cos(2*Az)
	dAz=amod(dAz,360.)
	if(abs(dAz).gt.180.) dAz=dAz-sign(360.,dAz)
c ********** Model for altitude offset **********
	A=Az
	if(Alt.gt.pi/2) A=pi+A
	dAlt= p(2)	! encoder offset
     *+p(5)*cos(A)	! tilt out  (toward Az=0 deg)
     *+p(6)*sin(A)	! tilt over (toward Az=90 deg)	
     *+p(7)*cos(Alt)	! sag
     *+p(8)*sin(Alt)	! ad hoc
     *+p(11)*sin(2*A)	! ad hoc
	if(Hjump(Az,Alt).gt.0.) dAlt=dAlt+p(12)
	end
