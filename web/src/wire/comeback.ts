/** Tells what stands still that asking again makes sense: the hub is there again, or somebody has signed in. */

export class Comeback {
  private readonly waiting = new Set<() => void>();

  /** Calls `resume` each time, until what it returns is called. */
  subscribe(resume: () => void): () => void {
    this.waiting.add(resume);
    return () => this.waiting.delete(resume);
  }

  announce(): void {
    for (const resume of [...this.waiting]) resume();
  }
}

/** That of this page: sockets and questions everywhere wait for the same hub. */
export const comeback = new Comeback();
