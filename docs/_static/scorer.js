// How the search orders what it finds: a recipe that has all the words comes before other pages that have them, because
// who searches wants to do something. The other numbers are those of Sphinx.
var Scorer = {
  score: ([docname, , , , score]) => score + (docname.startsWith("howto/") ? 10 : 0),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
