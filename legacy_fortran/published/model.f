	subroutine Model(Az,Alt,dAz,dAlt,p)
c RT32 model for azimuth (Az) and altitude (Alt) pointing 
c offsets, dAz, dAlt. Parameters p are in degrees, so are the
c offsets while Az and Alt must be supplied in radians.
c It is more accurate version of Model3A with exact analytical 
c expressions for effects of telescope tilt, elevation axis
c skew and main lobe offset.
	implicit real*8 (a-h,o-z)
	real*4 Az,dAz,Alt,dAlt,p(12),Hjump
	data pi/3.141592653589793d0/
	arcsin(arg)=dasin(dmin1(1.d0,dmax1(-1.d0,arg)))
	xi=p(5)*pi/180d0	! tilt out  (toward Az=0 deg)
	zeta=p(6)*pi/180d0	! tilt over (toward Az=90 deg)
	sigma=p(3)*pi/180d0	! skew
	beta=p(4)*pi/180d0	! beam (box) offset
	sh=dsin(Alt)
	ch=dcos(Alt)

c Tilt
	se=dsign(dsqrt(dsin(xi)**2+dsin(zeta)**2),ch)
	ce=dsqrt(1-se*se)
	alfa=datan2(dsin(zeta),dsin(xi))
	AT=datan2(ch*dsin(alfa-Az),sh*se-ch*ce*dcos(alfa-Az))
     *-datan2(dsin(alfa),-ce*dcos(alfa))
	hT=dasin(ce*sh+se*ch*dcos(alfa-Az))
	AT_Az=AT - Az
		if(ch.lt.0d0) then
	AT_Az=pi-AT_Az
	hT=pi-hT
		endif

c Skew & box offset together (good also for hT > pi/2)
	dAz=arcsin( (dsin(sigma)*dsin(hT)+
     *dsin(beta))/(dcos(hT)*dcos(sigma)) )
	hb=datan2(dsin(hT)*dcos(sigma)
     *+cos(hT)*sin(sigma)*dsin(dAz),dcos(hT)*dcos(dAz))

	dAz=dmod((dAz+AT_Az)*180/pi,360d0)
     *+p(1)     	! encoder offset
     *+p(9)*sin(2*Az)	! ad hoc
     *+p(10)*cos(2*Az)	! ad hoc
	if(dabs(dAz).gt.180d0) dAz=dAz-dsign(360d0,dAz)

	dAlt= (hb-Alt)*180/pi
     *+p(2)		! encoder offset
     *+p(7)*ch		! sag
     *+p(8)*sh		! ad hoc
     *+p(11)*sin(2*Az)	! ad hoc
	if(Hjump(Az,Alt).gt.0.) dAlt=dAlt+p(12)
	end
