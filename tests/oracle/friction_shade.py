#!/usr/bin/env python3
"""Which friction term leaves the least when spike and decay are known with errors that are correlated?

  python3 tests/oracle/friction_shade.py

Behind `prudent` in src/fit: a slow circle fixes the lag some 8 s after a reversal (2 %), spike and decay move along a ridge
through it (6.5 % of the spike). For 300 machines drawn along that ridge the script compensates the first joint of the circle
with a spike of f times the estimate (and the decay that keeps the lag), runs machine and command, and prints the largest
error in um. A spike that is too large overshoots at once; one that is too small leaves the joint standing, which costs little while
the command is slow: 0.95 (0.75 standard errors) is best. Needs numpy; uses the twin's inverse kinematics beside it.
"""
import pathlib, sys
import numpy as np
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import twin
# A1 travel after its turn on the smooth circle at 1.5 mm/s
phi=np.radians(88.7+np.linspace(0,360,2_000_00)); xyz=np.stack([np.full_like(phi,1780.),450+250*np.cos(phi),1200+250*np.sin(phi)],1)
q=twin.inverse3(xyz)[:,0]; t=np.radians(np.linspace(0,360,len(phi)))*250/1.5
i=np.argmax(q); s=t[i:]-t[i]; z=q[i]-q[i:]; m=s<40; s=s[m][::4]; z=z[m][::4]
b=.0028; lever=np.hypot(1780,450+0)*1000*np.pi/180  # um/deg approx
def solve(g,tau):
    G=g*np.exp(-s/tau); H=z+b+G
    suf=np.minimum.accumulate(H[::-1])[::-1]; D=np.maximum.accumulate((H-suf)[::-1])[::-1]
    k=np.argmax(D<=2*z); pm=np.maximum.accumulate(H[k:]); C=H.copy(); C[k:]=.5*(pm+suf[k:]); C[:k]=C[k]; return C
def err(C,g,tau):
    G=g*np.exp(-s/tau); out=np.maximum.accumulate(np.maximum(0,C-b-G)); e=out-z
    w=int(1/(s[1]-s[0])); es=np.convolve(e,np.ones(w)/w,'same'); return np.abs(es).max()*lever
ts,lag=8.0,.0034*np.exp(-8/5.2)
rng=np.random.default_rng(0)
true=[(lambda k:(lag*np.exp(rng.normal(0,.02))*np.exp(ts*k),1/k))((1/5.2)*(1+rng.normal(0,.065/(ts/5.2)))) for _ in range(300)]
print('sd ln g', np.std([np.log(x[0]) for x in true]))
for f in (0.8,.85,.9,.95,1,1.05,1.1):
    k=1/5.2+np.log(f)/ts; C=solve(lag*np.exp(ts*k),1/k)
    e=np.array([err(C,*x) for x in true]); print('ridge g x',f,'tau %.2f'%(1/k),'mean %.2f p90 %.2f max %.2f; at truth %.2f'%(e.mean(),np.quantile(e,.9),e.max(),err(C,.0034,5.2)))
