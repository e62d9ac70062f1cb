"""What each number means, and where its definition comes from.

Lengths are in metres here; whoever shows them may convert them by their unit.
"""

from __future__ import annotations

from dataclasses import dataclass

GAO = 'Gao et al. 2018, doi:10.1088/1758-5090/aacdc7'
RIBEIRO = 'Ribeiro et al. 2018, doi:10.1088/1758-5090/aa90e2'
OUYANG = 'Ouyang et al. 2016, doi:10.1088/1758-5090/8/3/035020'
MESH = 'PMC10708124'
OCT = 'Int. J. Bioprinting 9(3), p. 241'
RATIO = 'Tian et al. 2021'
PIPELINE = 'github.com/tmcr1234/diw-bioprinting-pipeline'
OWN = 'bpc'


@dataclass(frozen=True)
class Definition:
    """What a number means.

    Attributes:
        unit: 'm', 'm^2', '%', or empty for a plain number.
        text: how it is found, in a sentence.
        source: who defines it so.
    """

    unit: str
    text: str
    source: str


DEFINITIONS = {
    'width': Definition('m', 'mean width of the measured samples', OWN),
    'filament_to_nozzle_ratio': Definition(
        '', 'mean width / inner diameter of the nozzle', RATIO),
    'uniformity': Definition(
        '', "U = length of the strand's two edges / length of two straight ones; 1 = uniform",
        GAO),
    'stability': Definition(
        '', 'S = 1 - standard deviation / mean of the width; 1 = stable, 0 = not printable', OCT),
    'width_accuracy': Definition('%', 'mean of width / target x 100', MESH),
    'continuity': Definition('', 'length of the ink that is seen / length that was commanded',
                             PIPELINE),
    'turn_fidelity': Definition(
        '', 'share of the turns whose width at the apex is 0.7 to 1.5 of the median width',
        PIPELINE),
    'strand_distance': Definition('m', 'f_d: between the lines of two parallel strands', RIBEIRO),
    'fused_length': Definition('m', 'f_s: along which two parallel strands touch', RIBEIRO),
    'fusion': Definition('', 'f_s / f_t: fused length / strand width, to be drawn over f_d',
                         RIBEIRO),
    'collapse_factor': Definition(
        '%', 'Cf = (A_t - A_a) / A_t x 100, A_t theoretical and A_a actual area under a strand '
        'that spans; 0 = it does not sag. Some papers, as PMC10708124, say A_a / A_t instead',
        OCT),
    'pore_area': Definition('m^2', 'A: mean area of the pores', OUYANG),
    'pore_printability': Definition(
        '', 'Pr = L^2 / (16 A), mean of the pores with perimeter L and area A; square 1, '
        'circle pi/4', OUYANG),
    'mesh_printability': Definition(
        '%', 'actual / intended area of a pore x 100, mean of the pores; intended is the area '
        'between strands of target width on the lines of the path', MESH),
    'pore_size_accuracy': Definition(
        '%', 'measured / theoretical size of a pore x 100, mean of the pores; size is the square '
        'root of the area', MESH),
}
