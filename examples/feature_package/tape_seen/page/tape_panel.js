// How many rays meet tape, and a button that creeps towards it.
export function panel(body, program) {
  const count = document.createElement("p");
  const creep = document.createElement("button");
  creep.textContent = "creep";
  creep.onclick = () => program.order({ type: "creep" });
  body.append(count, creep);
  return {
    show({ values }) {
      count.textContent = `${values?.tape_rays ?? "no"} rays meet tape`;
    },
  };
}
