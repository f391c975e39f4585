<?xml version="1.0" encoding="UTF-8"?>
<ColorCorrection id="warm">
    <SOPNode>
        <Description>A warm grade.</Description>
        <Slope>1.1 1.0 0.9</Slope>
        <Offset>0.01 0.0 -0.02</Offset>
        <Power>1.2 1.0 0.8</Power>
    </SOPNode>
    <SATNode>
        <Saturation>1.25</Saturation>
    </SATNode>
</ColorCorrection>
