/** A night's blocks along one line: where each stands, which mark its proposal has, which is next. Pure. */

/** What became of a block, or will. */
export type BlockState = "planned" | "current" | "done" | "suspended" | "failed";

/** One visit, done or to be done (ms since 1970). */
export interface NightBlock {
  readonly id: string;
  readonly request: string;
  /** What is looked at. */
  readonly name: string;
  readonly proposal: string;
  readonly startMs: number;
  readonly endMs: number;
  readonly state: BlockState;
  /** Why it stands here, or what became of it. */
  readonly reason: string;
  /** What comes between its frames, or just before them; nothing of what was done is known. */
  readonly pauses?: readonly BlockPause[];
}

/** The mount's turn at the meridian, or a focus run (ms since 1970). */
export interface BlockPause {
  readonly kind: "flip" | "focus";
  readonly startMs: number;
  readonly endMs: number;
  readonly reason: string;
}

/** A pause's place on the line, as parts of it. */
export interface PlacedPause extends BlockPause {
  readonly left: number;
  readonly width: number;
}

interface NightWindow {
  readonly from: number;
  readonly to: number;
}

/** A block's place on the line, as parts of it. */
export interface PlacedBlock extends NightBlock {
  readonly left: number;
  readonly width: number;
}

/** Blocks that lie at least partly in the window, in order of their start, cut to it. */
export function placeBlocks(blocks: readonly NightBlock[], { from, to }: NightWindow): readonly PlacedBlock[] {
  const span = Math.max(1, to - from);
  return [...blocks]
    .filter(({ startMs, endMs }) => endMs > from && startMs < to)
    .sort((a, b) => a.startMs - b.startMs || a.id.localeCompare(b.id))
    .map((block) => {
      const left = (Math.max(from, block.startMs) - from) / span;
      return { ...block, left, width: (Math.min(to, block.endMs) - from) / span - left };
    });
}

/** Pauses of blocks that lie at least partly in the window, cut to it. */
export function placePauses(blocks: readonly NightBlock[], { from, to }: NightWindow): readonly PlacedPause[] {
  const span = Math.max(1, to - from);
  return blocks
    .flatMap(({ pauses }) => pauses ?? [])
    .filter(({ startMs, endMs }) => endMs > from && startMs < to)
    .map((pause) => {
      const left = (Math.max(from, pause.startMs) - from) / span;
      return { ...pause, left, width: (Math.min(to, pause.endMs) - from) / span - left };
    });
}

/** Where a moment stands on the line; null outside of it. */
export function placeMoment(ms: number, { from, to }: NightWindow): number | null {
  return ms >= from && ms <= to ? (ms - from) / Math.max(1, to - from) : null;
}

/** The window of a night: what is planned and done, and half an hour on each side, in whole half hours. */
export function nightWindow(night: NightWindow, blocks: readonly NightBlock[]): NightWindow {
  const half = 1_800_000;
  const starts = blocks.map(({ startMs }) => startMs);
  const ends = blocks.map(({ endMs }) => endMs);
  const from = Math.min(night.from, ...starts) - half / 2;
  const to = Math.max(night.to, ...ends) + half / 2;
  return { from: Math.floor(from / half) * half, to: Math.ceil(to / half) * half };
}

/** A proposal's mark: a letter for eyes that tell no colours apart, and one of eight colours. */
export interface ProposalMark {
  readonly letter: string;
  /** 1 to 8, as the tokens count. */
  readonly colour: number;
}

/** The same proposals have the same marks, in whatever order they come. */
export function proposalMarks(proposals: Iterable<string>): ReadonlyMap<string, ProposalMark> {
  const all = [...new Set(proposals)].sort();
  return new Map(all.map((proposal, i) => [proposal, { letter: letterOf(i), colour: (i % 8) + 1 }]));
}

/** A to Z, then AA, AB. */
function letterOf(index: number): string {
  const last = String.fromCharCode(65 + (index % 26));
  return index < 26 ? last : letterOf(Math.floor(index / 26) - 1) + last;
}

/** The block that an arrow leads to; the one itself at the ends, the first without one. */
export function stepBlock(blocks: readonly NightBlock[], id: string, key: string): NightBlock | undefined {
  const at = blocks.findIndex((block) => block.id === id);
  switch (key) {
    case "ArrowRight":
    case "ArrowDown":
      return blocks[Math.min(blocks.length - 1, at + 1)];
    case "ArrowLeft":
    case "ArrowUp":
      return blocks[Math.max(0, at - 1)];
    case "Home":
      return blocks[0];
    case "End":
      return blocks.at(-1);
    default:
      return undefined;
  }
}

/** Block time (ms) of each proposal in what was done. */
export function timeByProposal(blocks: readonly NightBlock[]): ReadonlyMap<string, number> {
  const spent = new Map<string, number>();
  for (const { proposal, startMs, endMs, state } of blocks) {
    if (state !== "planned") spent.set(proposal, (spent.get(proposal) ?? 0) + endMs - startMs);
  }
  return spent;
}
