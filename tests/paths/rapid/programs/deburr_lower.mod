module deburr
! quick deburr test, everything in lower case, loops by goto
pers tooldata tspindle := [true, [[0, 0, 205], [1, 0, 0, 0]], [4, [0, 0, 90], [1, 0, 0, 0], 0, 0, 0]];
const robtarget pstart := [[1400, -150, 650], [0, 0, 1, 0], [-1, 0, -1, 0], [9e9, 9e9, 9e9, 9e9, 9e9, 9e9]];
var num i;
var num pass := 0;
var num side{4, 2} := [[120, 0], [120, 80], [0, 80], [0, 0]];
var robtarget p;

proc main()
  confl \off;
  movej offs(pstart, 0, 0, 50), v500, fine, tspindle;
again:
  pass := pass + 1;
  setdo dospindle, 1;
  movel pstart, v100, fine, tspindle;
  i := 1;
next:
  p := offs(pstart, side{i, 1}, side{i, 2}, -0.2 * pass);
  movel p, v50, z1, tspindle;
  i := i + 1;
  if i <= 4 goto next;
  movel offs(p, 0, 0, 50), v200, fine, tspindle;
  setdo dospindle, 0;
  if pass < 2 goto again;
  if testdi(direpeat) then
    pass := 0;
    goto again;
  endif
endproc
endmodule
