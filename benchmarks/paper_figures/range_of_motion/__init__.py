"""Table 1 and the figures of Ribera et al. 2017, *Facial Retargeting with Automatic Range of Motion Alignment*."""
